# tandem_library(NAME SOURCES... HEADERS...): one library of the house, with its alias, warnings and install rules.
function(tandem_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;HEADERS")
  add_library(tandem_${name} ${arg_SOURCES})
  add_library(tandem::${name} ALIAS tandem_${name})
  set_target_properties(tandem_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(tandem_${name} PUBLIC cxx_std_20)
  target_sources(tandem_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  target_include_directories(tandem_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  tandem_flags(tandem_${name})
  install(TARGETS tandem_${name} EXPORT tandemTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

function(tandem_flags target)
  # In a host's unity build its files stay apart: each has short names of its own.
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  # SSSE3 without SSE4 was built from 2006 to 2008: not worth the tenth of the time that its kernels take to compile.
  target_compile_definitions(${target} PRIVATE HWY_DISABLED_TARGETS=HWY_SSSE3)
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-Wall -Wextra -Wpedantic -Wconversion>
    # Fusing a*b+c changes rounding, and with it contacts: the same bits are promised on every machine.
    $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-ffp-contract=off>
    $<$<AND:$<BOOL:${TANDEM_WARNINGS_AS_ERRORS}>,$<CXX_COMPILER_ID:GNU,Clang,AppleClang>>:-Werror>)
endfunction()

# tandem_precompile(TARGET HEADERS...) or (TARGET REUSE_FROM OTHER): headers that most of its files include, read once: two
# thirds of the time that most files take is reading Eigen. More than is needed costs: with JSON's and CLI11's headers files
# took longer than without.
function(tandem_precompile target)
  if(TANDEM_PRECOMPILE_HEADERS)
    if(ARGV1 STREQUAL REUSE_FROM)
      target_precompile_headers(${target} REUSE_FROM ${ARGV2})
    else()
      target_precompile_headers(${target} PRIVATE ${ARGN})
    endif()
  endif()
endfunction()

# tandem_front(FILES...): what reads options and writes text around the work. At -O3 it takes half as long again to compile
# and no less to run.
function(tandem_front)
  set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
endfunction()
