# Builds with sanitizers (LAPPET_SANITIZE: address,undefined or thread): every finding ends the program. Assertions of the
# standard library and of Eigen are on. Of the kernels only the scalar ones are built: the others come from the same source
# and take minutes each.
if(NOT LAPPET_SANITIZE)
  return()
endif()
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1")
target_compile_definitions(lappet_flags INTERFACE LAPPET_SCALAR_KERNELS _GLIBCXX_ASSERTIONS)
target_compile_options(
  lappet_flags
  INTERFACE "-fsanitize=${LAPPET_SANITIZE}" -fno-sanitize-recover=all -fno-omit-frame-pointer
            # g++ 12 takes what instrumentation keeps for uninitialized or out of bounds
            -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow)
target_link_options(lappet_flags INTERFACE "-fsanitize=${LAPPET_SANITIZE}")
if(LAPPET_SANITIZE MATCHES "undefined")
  # The address sanitizer ends the program where these would, and they are a third of the time to compile.
  target_compile_options(lappet_flags INTERFACE -fno-sanitize=null,object-size,vptr)
endif()

# Removes the sources of the other instruction sets from a list, and of the tests that compare sets. Memory is what can go
# wrong in a kernel: it is checked by calls, which compile in a third of the time.
function(lappet_scalar_kernels_only sources_variable)
  set(sources ${${sources_variable}})
  list(FILTER sources EXCLUDE REGEX "_(sse42|avx2|avx512|neon)\\.cpp$|_twins")
  foreach(source IN LISTS sources)
    if(source MATCHES "/elastic_kernels_scalar\\.cpp$" AND LAPPET_SANITIZE MATCHES "undefined")
      set_source_files_properties("${source}" PROPERTIES COMPILE_OPTIONS
        "-fno-sanitize=undefined;--param=asan-instrumentation-with-call-threshold=0")
    endif()
  endforeach()
  set(${sources_variable} ${sources} PARENT_SCOPE)
endfunction()
