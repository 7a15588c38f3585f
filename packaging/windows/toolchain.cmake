# Compiles for Windows on x86-64 with Debian's mingw-w64. LAPPET_WINDOWS_PREFIX has the libraries that
# packaging/windows/cross_build.sh makes; headers of Debian's -dev packages are found by the files in cmake/.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
# Windows keeps stacks at 16 bytes, and GCC moves vectors of 32 and 64 bytes there as if they were aligned (GCC bug
# 54412): the assembler writes the moves that take any address.
set(CMAKE_CXX_FLAGS_INIT "-Wa,-muse-unaligned-vector-move")
set(CMAKE_C_FLAGS_INIT "-Wa,-muse-unaligned-vector-move")
# The run time of C++ and its threads are linked into the program: nothing of mingw-w64 goes with it.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
get_filename_component(LAPPET_WINDOWS_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../build/windows/prefix" ABSOLUTE)
set(CMAKE_FIND_ROOT_PATH "${LAPPET_WINDOWS_PREFIX}" /usr/x86_64-w64-mingw32)
set(CMAKE_PREFIX_PATH "${CMAKE_CURRENT_LIST_DIR}/cmake;${LAPPET_WINDOWS_PREFIX}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
find_program(LAPPET_WINE NAMES wine64 wine PATHS /usr/lib/wine)
if(LAPPET_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR "${LAPPET_WINE}")
endif()
