# Runs PAIR_FUZZ, the fuzz target built with clang, RUNS times from REPLAY's seeds on, in the folder WORK: the same inputs
# each time, as long as the code is the same. Prints "skipped: " and the reason if there is none.
include(${SOURCE}/tests/clang.cmake)
if(NOT CLANG_FUZZES)
  message(STATUS "skipped: there is no clang++ that links -fsanitize=fuzzer (Debian: clang libclang-rt-dev)")
  return()
endif()
file(REMOVE_RECURSE ${WORK}/seeds)
file(MAKE_DIRECTORY ${WORK}/seeds)
execute_process(COMMAND ${REPLAY} --seeds ${WORK}/seeds COMMAND_ERROR_IS_FATAL ANY)
# Sorted by name: the order of a folder differs between machines.
file(GLOB seeds ${WORK}/seeds/*)
list(SORT seeds)
list(JOIN seeds "," seeds)
# Without the use of compared values: pointers are among them, and differ between runs.
execute_process(COMMAND ${PAIR_FUZZ} -seed=1 -runs=${RUNS} -use_cmp=0 -max_total_time=300 -max_len=400
    -timeout=60 -rss_limit_mb=1024 -artifact_prefix=${WORK}/ -seed_inputs=${seeds}
  COMMAND_ERROR_IS_FATAL ANY)
