# Builds with sanitizers (LAPPET_SANITIZE: address,undefined or thread): every finding ends the program. Assertions of the
# standard library and of Eigen are on. Of the kernels only those that every x86-64 since 2009 runs are built: the others
# come from the same source and take minutes each.
if(NOT LAPPET_SANITIZE)
  return()
endif()
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1")
target_compile_definitions(lappet_flags INTERFACE LAPPET_BASELINE_KERNELS _GLIBCXX_ASSERTIONS)
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
