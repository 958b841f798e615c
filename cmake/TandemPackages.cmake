# Debian packages, by `cpack` in the build folder of the preset `packages`: libtandem0 (the shared library), libtandem-dev
# (headers, static libraries), tandem-tools (the programs).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tandem)
set(CPACK_PACKAGE_VENDOR "tandem")
set(CPACK_PACKAGE_CONTACT "tandem developers <tandem@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime dev tools)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libtandem${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(control ${CMAKE_CURRENT_BINARY_DIR}/debian/control)
file(WRITE ${control}/shlibs "libtandem ${PROJECT_VERSION_MAJOR} libtandem${PROJECT_VERSION_MAJOR} (>= ${PROJECT_VERSION})\n")
file(WRITE ${control}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${control}/shlibs ${control}/triggers)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "collision detection on many cores (shared library)
 Broad and narrow phase run at once as a task graph of oneTBB; answers are the same bits
 on any number of threads.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libtandem-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libtandem${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}), libtbb-dev, libeigen3-dev, libhwy-dev, libqhull-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "libfcl-dev, libccd-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION "collision detection on many cores (headers and static libraries)
 For programs that use tandem by CMake's find_package(tandem) or pkg-config. The component
 fcl, for programs written for FCL, needs libfcl-dev.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME tandem-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION science)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "collision detection on many cores (programs)
 tandem runs scenes, answers pairs of shapes and finds clashes; tandem-bench measures,
 compares with other libraries, and writes reports as pages.")

# Each package has what Debian asks for: its licence and what has changed.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component runtime dev tools)
  string(TOUPPER ${component} upper)
  set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/debian/${name})
  file(WRITE ${folder}/copyright "Files: *\nCopyright: 2026 tandem developers\nLicense: Apache-2.0\n On Debian systems, its text is in /usr/share/common-licenses/Apache-2.0.\n")
  file(WRITE ${folder}/changelog "${CPACK_PACKAGE_NAME} (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See the project's CHANGELOG.md.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  execute_process(COMMAND gzip -9nf ${folder}/changelog)
  install(FILES ${folder}/copyright ${folder}/changelog.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
    COMPONENT ${component} EXCLUDE_FROM_ALL)  # by cpack alone
endforeach()
include(CPack)
