# Runs FUZZ, libFuzzer's target for READER built with clang, RUNS times from the committed files on, in the folder WORK.
# Prints "skipped: " and the reason if there is no such target.
include(${SOURCE}/tests/clang.cmake)
if(NOT CLANG_FUZZES)
  message(STATUS "skipped: there is no clang++ that links -fsanitize=fuzzer (Debian: clang libclang-rt-dev)")
  return()
endif()
file(MAKE_DIRECTORY ${WORK})
# Sorted by name: the order of a folder differs between machines.
file(GLOB seeds ${SOURCE}/tests/engine/fuzz/corpus/${READER}/*)
list(SORT seeds)
list(JOIN seeds "," seeds)
if(READER MATCHES "^(obj|stl|ply|off)$")
  set(words mesh)
else()
  set(words json)
endif()
# Without the use of compared values: pointers are among them, and differ between runs. -timeout: seconds per input.
execute_process(COMMAND ${FUZZ} -seed=1 -runs=${RUNS} -use_cmp=0 -max_len=4096 -timeout=20 -rss_limit_mb=1024
    -malloc_limit_mb=256 -print_final_stats=1 -artifact_prefix=${WORK}/ -seed_inputs=${seeds}
    -dict=${SOURCE}/tests/engine/fuzz/${words}.dict
  COMMAND_ERROR_IS_FATAL ANY)
