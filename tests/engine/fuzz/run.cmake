# Runs FUZZ, libFuzzer's target for READER built with clang, RUNS times from the committed files on, in the folder WORK.
# Says "skipped: " and why where there is none.
include(${SOURCE}/tests/clang.cmake)
if(NOT CLANG_FUZZES)
  message(STATUS "skipped: there is no clang++ that links -fsanitize=fuzzer (Debian: clang libclang-rt-dev)")
  return()
endif()
file(MAKE_DIRECTORY ${WORK})
# By name: a folder's own order differs from machine to machine.
file(GLOB seeds ${SOURCE}/tests/engine/fuzz/corpus/${READER}/*)
list(SORT seeds)
list(JOIN seeds "," seeds)
if(READER MATCHES "^(obj|stl|ply|off)$")
  set(words mesh)
else()
  set(words json)
endif()
# Without compared values: pointers are among them, and differ from run to run. -timeout is of one input, in seconds.
execute_process(COMMAND ${FUZZ} -seed=1 -runs=${RUNS} -use_cmp=0 -max_len=4096 -timeout=20 -rss_limit_mb=1024
    -malloc_limit_mb=256 -print_final_stats=1 -artifact_prefix=${WORK}/ -seed_inputs=${seeds}
    -dict=${SOURCE}/tests/engine/fuzz/${words}.dict
  COMMAND_ERROR_IS_FATAL ANY)
