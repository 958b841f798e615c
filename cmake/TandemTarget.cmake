# tandem_library(NAME SOURCES... HEADERS... [EXPORT SET] [COMPONENT NAME]): one static library, with its alias, warnings and
# install rules. The shared library consists of those of EXPORT tandemTargets; COMPONENT names the package it is in.
function(tandem_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "EXPORT;COMPONENT" "SOURCES;HEADERS")
  add_library(tandem_${name} STATIC ${arg_SOURCES})
  add_library(tandem::${name} ALIAS tandem_${name})
  set_target_properties(tandem_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(tandem_${name} PUBLIC cxx_std_20)
  target_sources(tandem_${name} PRIVATE ${arg_HEADERS})
  target_include_directories(tandem_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(tandem_${name} PUBLIC tandem_version)
  tandem_flags(tandem_${name})
  tandem_private_functions(tandem_${name})
  if(NOT arg_EXPORT)
    set(arg_EXPORT tandemTargets)
  endif()
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT dev)
  endif()
  tandem_install(TARGETS tandem_${name} EXPORT ${arg_EXPORT}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${arg_COMPONENT})
  foreach(header IN LISTS arg_HEADERS)
    get_filename_component(folder ${header} DIRECTORY)
    string(REGEX REPLACE "^include" "" folder ${folder})
    tandem_install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}${folder} COMPONENT ${arg_COMPONENT})
  endforeach()
endfunction()

# tandem_install(...): install(...) if installation is on: nothing goes to a parent project's prefix unasked.
function(tandem_install)
  if(TANDEM_INSTALL)
    install(${ARGV})
  endif()
endfunction()

# Instruction sets for which Highway compiles nothing. On ARM all but NEON: vectors whose length only the running
# processor knows (SVE) fit into no array, and g++ 12 fails on them; Highway before 1.0.5 has NEON only with the AES
# instructions, which no kernel here uses. SSSE3 without SSE4 was built from 2006 to 2008: not worth a tenth of the
# kernels' compile time. AVX3_DL, the additions of Ice Lake, has nothing that a kernel uses, and where the flags of all
# targets ask for it (-march=native on Sapphire Rapids), Highway 1.0.3 compiles nothing at all.
set(TANDEM_HIGHWAY_OPTIONS)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64|ARM64)$")
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_LIBRARIES hwy::hwy)
  check_cxx_source_compiles("#include <hwy/detect_targets.h>\nlong long x = HWY_NEON_WITHOUT_AES;\nint main() {}" TANDEM_NEON_WITHOUT_AES)
  unset(CMAKE_REQUIRED_LIBRARIES)
  if(TANDEM_NEON_WITHOUT_AES)
    set(TANDEM_DISABLED_TARGETS "(HWY_NEON_WITHOUT_AES-1)")  # what is better has lower bits
  else()
    set(TANDEM_DISABLED_TARGETS "(HWY_NEON-1)")
    set(TANDEM_HIGHWAY_OPTIONS -march=armv8-a+crypto)
  endif()
else()
  set(TANDEM_DISABLED_TARGETS "(HWY_SSSE3|HWY_AVX3_DL)")
endif()

function(tandem_flags target)
  # In a unity build kernels are compiled alone: Highway compiles the whole file once for each instruction set.
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_filename_component(path ${source} ABSOLUTE)
    if(path MATCHES "\\.cpp$" AND EXISTS ${path})  # what is generated is no kernel
      file(STRINGS ${path} kernel REGEX "hwy/foreach_target.h" LIMIT_COUNT 1)
      if(kernel)
        set_source_files_properties(${path} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endif()
  endforeach()
  target_compile_definitions(${target} PRIVATE
    TANDEM_DISABLED_TARGETS=${TANDEM_DISABLED_TARGETS} HWY_DISABLED_TARGETS=TANDEM_DISABLED_TARGETS
    # Answers have the same bits on every machine. Eigen's vector code sums in another order than its scalar code, and
    # fuses a*b+c on 64-bit ARM. Without vector code Eigen would no longer align its types: 16 bytes are its choice on
    # both architectures, and that of libraries that take its types, such as FCL.
    EIGEN_DONT_VECTORIZE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MAX_STATIC_ALIGN_BYTES=16
    $<$<BOOL:${TANDEM_ONE_INSTRUCTION_SET}>:HWY_COMPILE_ONLY_STATIC>)
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-Wall -Wextra -Wpedantic -Wconversion>
    # A unity build includes sources, whose anonymous namespaces g++ would report as those of headers.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>
    # For the same reason sums and products are computed as written, whatever flags a host gives to all its targets.
    $<$<CXX_COMPILER_ID:GNU,Clang,AppleClang>:-fno-fast-math -ffp-contract=off>
    ${TANDEM_HIGHWAY_OPTIONS}
    $<$<AND:$<BOOL:${TANDEM_WARNINGS_AS_ERRORS}>,$<CXX_COMPILER_ID:GNU,Clang,AppleClang>>:-Werror>)
endfunction()

# tandem_private_functions(LIBRARY): a static library calls its own copies of inline functions, never a host's
# (PrivateFunctions.cmake). If objects hold no code yet (link-time optimisation) or are not ELF, it may call a host's.
set(TANDEM_PRIVATE_FUNCTIONS ${CMAKE_CURRENT_LIST_DIR}/PrivateFunctions.cmake)
function(tandem_private_functions library)
  get_target_property(type ${library} TYPE)
  get_target_property(link_time ${library} INTERPROCEDURAL_OPTIMIZATION)
  if(type STREQUAL STATIC_LIBRARY AND CMAKE_EXECUTABLE_FORMAT STREQUAL ELF AND CMAKE_OBJCOPY AND NOT link_time
     AND NOT CMAKE_CXX_FLAGS MATCHES "-flto")
    add_custom_command(TARGET ${library} POST_BUILD VERBATIM
      COMMAND ${CMAKE_COMMAND} -DARCHIVE=$<TARGET_FILE:${library}> -DNM=${CMAKE_NM} -DOBJCOPY=${CMAKE_OBJCOPY}
              -P ${TANDEM_PRIVATE_FUNCTIONS})
  endif()
endfunction()

# tandem_precompile(TARGET HEADERS...) or (TARGET REUSE_FROM OTHER): headers that most of its files include, read once:
# reading Eigen takes two thirds of the compile time of most files. Unneeded headers cost time: with JSON's and CLI11's
# headers files took longer than without.
function(tandem_precompile target)
  if(TANDEM_PRECOMPILE_HEADERS)
    if(ARGV1 STREQUAL REUSE_FROM)
      target_precompile_headers(${target} REUSE_FROM ${ARGV2})
    else()
      target_precompile_headers(${target} PRIVATE ${ARGN})
    endif()
  endif()
endfunction()

# tandem_front(FILES...): sources that read options and write text. At -O3 they take half as long again to compile, and no
# less to run.
function(tandem_front)
  set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
endfunction()
