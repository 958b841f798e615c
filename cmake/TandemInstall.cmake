# Installed beside libraries, headers and programs: the files of find_package and pkg-config, and Debian packages' data.
include(CMakePackageConfigHelpers)
set(files ${CMAKE_CURRENT_SOURCE_DIR}/cmake/install)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tandem)
configure_package_config_file(${files}/tandemConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/tandemConfig.cmake
  INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/tandemConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tandemConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/tandemConfigVersion.cmake
  DESTINATION ${package} COMPONENT dev)
install(EXPORT tandemTargets NAMESPACE tandem:: DESTINATION ${package} COMPONENT dev)
if(TANDEM_FCL_ADAPTER)
  install(EXPORT tandemFclTargets NAMESPACE tandem:: DESTINATION ${package} COMPONENT dev)
endif()
if(TANDEM_MPI)
  install(EXPORT tandemMpiTargets NAMESPACE tandem:: DESTINATION ${package} COMPONENT mpidev)
endif()
if(TANDEM_SHARED_LIBRARY)
  # The prefix is not known before installation.
  install(CODE "
    set(CMAKE_INSTALL_LIBDIR ${CMAKE_INSTALL_LIBDIR})
    set(CMAKE_INSTALL_INCLUDEDIR ${CMAKE_INSTALL_INCLUDEDIR})
    set(PROJECT_VERSION ${PROJECT_VERSION})
    set(PROJECT_DESCRIPTION [[${PROJECT_DESCRIPTION}]])
    configure_file(${files}/tandem.pc.in ${CMAKE_CURRENT_BINARY_DIR}/tandem.pc @ONLY)" COMPONENT dev)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tandem.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endif()
if(NOT SKBUILD)
  include(TandemPackages)
endif()
