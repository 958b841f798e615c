# Renames the inline functions in the static library ARCHIVE to private names, by the programs NM and OBJCOPY.
#
# A compiler that does not inline an inline function puts a copy of it into each object file, and the linker keeps the
# first copy of each name. If a host uses the same functions (Eigen's, or those of the public headers), that may be the
# copy compiled with the host's flags, such as -ffast-math or vectors of another width, and tandem's answers would
# depend on these. Variables keep their names: a program must have one of each.
foreach(variable ARCHIVE NM OBJCOPY)
  if(NOT ${variable})
    message(FATAL_ERROR "${variable} is not set")
  endif()
endforeach()
execute_process(COMMAND ${NM} --defined-only --format=sysv ${ARCHIVE} OUTPUT_VARIABLE symbols
                COMMAND_ERROR_IS_FATAL ANY)
# Lines of name, value, class, type and more. W: weak functions, and clang's thread-local variables (TLS). n: names of
# groups of functions, such as the two variants of a constructor.
string(REGEX MATCHALL "[^\n|]+\\|[0-9a-f]+\\| +[Wn] +\\|[^\n|]+" symbols "${symbols}")
list(FILTER symbols EXCLUDE REGEX "TLS$")
list(TRANSFORM symbols REPLACE " *\\|.*$" "")
list(REMOVE_DUPLICATES symbols)
list(FILTER symbols EXCLUDE REGEX "\\.tandem$")
list(TRANSFORM symbols REPLACE "^(.+)$" "\\1 \\1.tandem\n")
list(JOIN symbols "" symbols)
file(WRITE ${ARCHIVE}.renamed "${symbols}")
execute_process(COMMAND ${OBJCOPY} --redefine-syms=${ARCHIVE}.renamed ${ARCHIVE} COMMAND_ERROR_IS_FATAL ANY)
