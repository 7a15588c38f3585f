# Builds with sanitizers (LAPPET_SANITIZE: address,undefined or thread): every finding ends the program. Assertions of the
# standard library and of Eigen are on. They are built in CI from nothing, where minutes count:
# - Of the kernels only the scalar ones are built; the others come from the same source and take minutes each.
# - Of the unit tests those are left out that test numbers, and whose code others run as well: formulas of one matrix or one
#   cell, and series of large solves (kTestsOfNumbers below). Nothing is left out of what reads messages, files and surfaces,
#   of lattices, epochs, constraints, sessions and the broker.
# - What most files include is compiled once.
# - Of the undefined-behavior sanitizer those checks are left out that the address sanitizer makes too (a pointer that is
#   null, overflows or leads beyond its object ends there as well) and that of alignment, which the processors of the daemon
#   do not need: they stand at every access, and are more than half of what is compiled.
if(NOT LAPPET_SANITIZE)
  function(lappet_precompiled target)
  endfunction()
  return()
endif()
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1")
set(LAPPET_INSTRUCTION_SETS scalar)
target_compile_definitions(lappet_flags INTERFACE _GLIBCXX_ASSERTIONS)
target_compile_options(
  lappet_flags
  INTERFACE "-fsanitize=${LAPPET_SANITIZE}" -fno-sanitize-recover=all -fno-omit-frame-pointer
            # g++ 12 takes what instrumentation keeps for uninitialized or out of bounds
            -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow
            # what ccache needs to know of a precompiled header
            -fpch-preprocess)
target_link_options(lappet_flags INTERFACE "-fsanitize=${LAPPET_SANITIZE}")
if(LAPPET_SANITIZE MATCHES "undefined")
  target_compile_options(lappet_flags INTERFACE -fno-sanitize=null,object-size,vptr,alignment,pointer-overflow)
endif()
# One precompiled header for all: they must be compiled with the same macros.
target_link_libraries(lappet_flags INTERFACE Eigen3::Eigen TBB::tbb spdlog::spdlog cppzmq msgpackc-cxx Threads::Threads)

# Has a target use what most files of the libraries and of the tests include, compiled once.
function(lappet_precompiled target)
  if(TARGET lappet_precompiled_headers)
    target_precompile_headers(${target} REUSE_FROM lappet_precompiled_headers)
    return()
  endif()
  file(WRITE "${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp" "")
  add_library(lappet_precompiled_headers OBJECT "${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp")
  target_link_libraries(lappet_precompiled_headers PRIVATE lappet_flags)
  target_precompile_headers(
    lappet_precompiled_headers
    PRIVATE <algorithm> <array> <atomic> <chrono> <cmath> <cstddef> <cstdint> <functional> <limits> <map> <memory>
            <numeric> <optional> <random> <set> <span> <string> <string_view> <thread> <tuple> <utility> <vector>
            <Eigen/Dense> <tbb/blocked_range.h> <tbb/parallel_for.h> <tbb/task_arena.h>
            <spdlog/spdlog.h> <zmq.hpp> <gtest/gtest.h>)
  target_precompile_headers(${target} REUSE_FROM lappet_precompiled_headers)
endfunction()

set(kTestsOfNumbers
    # formulas of one matrix, or of one cell
    svd3 material material_states elastic fiber fiber_families prestretch augmented_lagrangian displacement_to_come
    # balances and series of solves, which take minutes here
    material_robustness material_session fiber_session layers_session prestretch_session reactions layer_shift
    preconditioner lowest_mode sheet convergence buckling)

# Removes the tests of numbers from a list of sources.
function(lappet_tests_of_memory_only sources_variable)
  set(sources ${${sources_variable}})
  foreach(name IN LISTS kTestsOfNumbers)
    list(FILTER sources EXCLUDE REGEX "/${name}_test\\.cpp$")
  endforeach()
  set(${sources_variable} ${sources} PARENT_SCOPE)
endfunction()

# Memory is what can go wrong in a kernel: it is checked by calls, which compile in a third of the time. Removes from a list
# the tests that compare instruction sets.
function(lappet_kernels_checked_by_calls sources_variable)
  set(sources ${${sources_variable}})
  list(FILTER sources EXCLUDE REGEX "_twins")
  foreach(source IN LISTS sources)
    if(source MATCHES "/elastic_kernels_scalar\\.cpp$" AND LAPPET_SANITIZE MATCHES "undefined")
      set_source_files_properties("${source}" PROPERTIES COMPILE_OPTIONS
        "-fno-sanitize=undefined;--param=asan-instrumentation-with-call-threshold=0")
    endif()
  endforeach()
  set(${sources_variable} ${sources} PARENT_SCOPE)
endfunction()
