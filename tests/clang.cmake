# Finds clang++ (CLANG) and whether it can link libFuzzer (CLANG_FUZZES), probing in the folder WORK.
find_program(CLANG NAMES clang++ clang++-14 clang++-15 clang++-16 clang++-17 clang++-18 clang++-19)
set(CLANG_FUZZES FALSE)
if(CLANG)
  file(MAKE_DIRECTORY ${WORK})
  file(WRITE ${WORK}/probe.cpp "extern \"C\" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }\n")
  execute_process(COMMAND ${CLANG} -fsanitize=fuzzer ${WORK}/probe.cpp -o ${WORK}/probe
    RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
  if(NOT failed)
    set(CLANG_FUZZES TRUE)
  endif()
endif()
