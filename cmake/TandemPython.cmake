# Finds Python and pybind11, for the module and what is built beside it.
set(PYBIND11_FINDPYTHON ON)
if(NOT SKBUILD AND NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)  # whose numpy and pybind11 are those of the system's packages
endif()
find_package(Python 3.7 REQUIRED COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.9 CONFIG REQUIRED)
set(TANDEM_PYTHON_INTERPRETER ${Python_EXECUTABLE} CACHE INTERNAL "Of the module's tests")
set(TANDEM_PYTHON_MINOR_VERSION ${Python_VERSION_MINOR} CACHE INTERNAL "3.x, of the module's package")
