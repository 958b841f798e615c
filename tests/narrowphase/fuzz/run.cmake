# Runs PAIR_FUZZ, the fuzz target built with clang, RUNS times from REPLAY's seeds on, in the folder WORK: the same inputs
# each time, as long as the code is the same. Says "skipped: " and why where there is none.
include(${SOURCE}/tests/clang.cmake)
if(NOT CLANG_FUZZES)
  message(STATUS "skipped: there is no clang++ that links -fsanitize=fuzzer (Debian: clang libclang-rt-dev)")
  return()
endif()
file(REMOVE_RECURSE ${WORK}/seeds)
file(MAKE_DIRECTORY ${WORK}/seeds)
execute_process(COMMAND ${REPLAY} --seeds ${WORK}/seeds COMMAND_ERROR_IS_FATAL ANY)
# By name: a folder's own order differs from machine to machine.
file(GLOB seeds ${WORK}/seeds/*)
list(SORT seeds)
list(JOIN seeds "," seeds)
# Without compared values: pointers are among them, and differ from run to run.
execute_process(COMMAND ${PAIR_FUZZ} -seed=1 -runs=${RUNS} -use_cmp=0 -max_total_time=300 -max_len=400
    -timeout=60 -rss_limit_mb=1024 -artifact_prefix=${WORK}/ -seed_inputs=${seeds}
  COMMAND_ERROR_IS_FATAL ANY)
