# Renames the inline functions in the static library ARCHIVE, by the programs NM and OBJCOPY, to names of its own.
#
# A compiler that does not inline an inline function puts a copy of it into each object file, and the linker keeps the
# first of those that have one name: where a host uses the same functions (Eigen's, or those of the public headers), that
# may be the one compiled with the host's flags, such as -ffast-math or vectors of another width, and tandem's answers
# would depend on them. Variables keep their names: there must be one of each in a program.
foreach(variable ARCHIVE NM OBJCOPY)
  if(NOT ${variable})
    message(FATAL_ERROR "${variable} is not set")
  endif()
endforeach()
execute_process(COMMAND ${NM} --defined-only ${ARCHIVE} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
# W: weak functions. n: names of groups of them, such as the two forms of a constructor.
string(REGEX MATCHALL "[0-9a-f]+ [Wn] [^\n]+" symbols "${symbols}")
list(TRANSFORM symbols REPLACE "^[0-9a-f]+ [Wn] " "")
list(REMOVE_DUPLICATES symbols)
list(FILTER symbols EXCLUDE REGEX "\\.tandem$")
list(TRANSFORM symbols REPLACE "^(.+)$" "\\1 \\1.tandem\n")
list(JOIN symbols "" symbols)
file(WRITE ${ARCHIVE}.renamed "${symbols}")
execute_process(COMMAND ${OBJCOPY} --redefine-syms=${ARCHIVE}.renamed ${ARCHIVE} COMMAND_ERROR_IS_FATAL ANY)
