# The target `docs`, if Doxygen is installed: the reference of the public headers and the guide, as offline pages.
find_program(TANDEM_DOXYGEN doxygen)
set(TANDEM_DOCS_FOLDER ${CMAKE_BINARY_DIR}/docs)
set(includes broadphase narrowphase flowgraph engine engine/formats engine/adapters/fcl engine/adapters/mpi)
list(TRANSFORM includes PREPEND ${PROJECT_SOURCE_DIR}/)
list(TRANSFORM includes APPEND /include)
set(pages guide guide.md python.md from-fcl.md scene-format.md record-format.md result-format.md install.md first-ten-minutes.md clash.md
  clearance.md continuous.md deformable.md depth.md inspect.md solvers.md mpi.md)
list(TRANSFORM pages PREPEND ${PROJECT_SOURCE_DIR}/docs/)
list(JOIN includes " " TANDEM_DOCS_INCLUDES)
list(JOIN pages " " pages)
set(TANDEM_DOCS_INPUT "${TANDEM_DOCS_INCLUDES} ${pages}")
configure_file(${PROJECT_SOURCE_DIR}/docs/Doxyfile.in ${TANDEM_DOCS_FOLDER}/Doxyfile @ONLY)
if(TANDEM_DOXYGEN)
  add_custom_target(docs
    COMMAND ${TANDEM_DOXYGEN} ${TANDEM_DOCS_FOLDER}/Doxyfile
    COMMAND ${CMAKE_COMMAND} -E echo "Pages, open in a browser: ${TANDEM_DOCS_FOLDER}/html/index.html"
    VERBATIM)
else()
  add_custom_target(docs
    COMMAND ${CMAKE_COMMAND} -E echo "docs: there is no doxygen (Debian: doxygen)"
    COMMAND ${CMAKE_COMMAND} -E false)
endif()
