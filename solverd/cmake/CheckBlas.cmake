# Refuses a BLAS that gives wrong numbers when several threads call it: sessions of several clients factor side by side.
if(CMAKE_CROSSCOMPILING OR LAPPET_BLAS_CHECKED)
  return()
endif()
message(STATUS "Checking the BLAS of CHOLMOD from several threads")
try_run(blas_is_wrong blas_compiles
        SOURCES "${CMAKE_CURRENT_LIST_DIR}/blas_from_threads.cpp"
                "${PROJECT_SOURCE_DIR}/solverd/src/platform/platform_posix.cpp"
        CMAKE_FLAGS "-DINCLUDE_DIRECTORIES=${PROJECT_SOURCE_DIR}/solverd/src" "-DCMAKE_BUILD_TYPE=Release"
        LINK_LIBRARIES CHOLMOD::CHOLMOD Threads::Threads ${CMAKE_DL_LIBS}
        CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON
        COMPILE_OUTPUT_VARIABLE said_by_compiler RUN_OUTPUT_VARIABLE found)
set(blas_status "${blas_is_wrong}")
unset(blas_is_wrong CACHE)  # asked again until it is right
string(STRIP "${found}" found)
if(NOT blas_compiles)
  message(FATAL_ERROR "The check of CHOLMOD's BLAS does not compile:\n${said_by_compiler}")
elseif(NOT blas_status STREQUAL "0")
  message(FATAL_ERROR "The BLAS that CHOLMOD loads cannot be called from several threads: ${found} Take one that can "
                      "(on Debian: apt-get install libopenblas0-pthread; its serial build cannot).")
endif()
set(LAPPET_BLAS_CHECKED ON CACHE INTERNAL "The BLAS of CHOLMOD gives the same numbers to several threads")
message(STATUS "Checking the BLAS of CHOLMOD from several threads - ${found}")
