# Runs PROGRAM in WORK; what it prints must be what WORK/printed.txt says.
execute_process(COMMAND ${PROGRAM} WORKING_DIRECTORY ${WORK} OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
file(READ ${WORK}/printed.txt expected)
if(NOT printed STREQUAL expected)
  message(FATAL_ERROR "printed:\n${printed}\nthe page says:\n${expected}")
endif()
