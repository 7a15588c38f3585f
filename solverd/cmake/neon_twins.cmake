# On x86, the NEON kernels: compiled with Debian's cross compiler where it is installed, and compared with their scalar
# twins under qemu-user where that is. Adds the target neon_twins and the test of the same name. Optimized little: the
# kernels take minutes to compile, and the source is what is compared.
find_program(LAPPET_AARCH64_CXX aarch64-linux-gnu-g++)
find_program(LAPPET_QEMU_AARCH64 NAMES qemu-aarch64 qemu-aarch64-static)
find_path(LAPPET_XSIMD_INCLUDE xsimd/xsimd.hpp)
if(NOT LAPPET_AARCH64_CXX OR NOT LAPPET_XSIMD_INCLUDE)
  return()
endif()

set(neon_directory "${CMAKE_CURRENT_BINARY_DIR}/neon")
# xsimd alone: the folder it lies in belongs to the processor of this machine
file(MAKE_DIRECTORY "${neon_directory}/include")
file(CREATE_LINK "${LAPPET_XSIMD_INCLUDE}/xsimd" "${neon_directory}/include/xsimd" SYMBOLIC)

set(neon_objects)
foreach(source tests/force/neon_twins tests/force/kernel_twins tests/force/kernel_twins_scalar
        tests/force/kernel_twins_neon tests/force/kernel_twins_check tests/force/kernel_twins_nodes
        tests/force/fused_twins_check src/force/kernels/elastic_kernels src/force/kernels/elastic_kernels_scalar
        src/force/kernels/elastic_kernels_neon)
  cmake_path(GET source FILENAME stem)
  set(object "${neon_directory}/${stem}.cpp.o")
  add_custom_command(
    OUTPUT "${object}"
    COMMAND ${CMAKE_CXX_COMPILER_LAUNCHER} "${LAPPET_AARCH64_CXX}" -std=c++20 -O1 -DLAPPET_BUILT_NEON -Wall -Wextra -Wpedantic -Werror
            "-I${CMAKE_CURRENT_SOURCE_DIR}/src" "-I${CMAKE_CURRENT_SOURCE_DIR}/tests" -isystem "${neon_directory}/include"
            -MMD -MF "${object}.d" -c "${CMAKE_CURRENT_SOURCE_DIR}/${source}.cpp" -o "${object}"
    DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/${source}.cpp"
    DEPFILE "${object}.d"
    COMMENT "Building for NEON ${stem}.cpp"
    VERBATIM)
  list(APPEND neon_objects "${object}")
endforeach()
add_custom_command(OUTPUT "${neon_directory}/neon_twins" DEPENDS ${neon_objects}
                   COMMAND "${LAPPET_AARCH64_CXX}" -static ${neon_objects} -o "${neon_directory}/neon_twins" VERBATIM)
add_custom_target(neon_twins DEPENDS "${neon_directory}/neon_twins")
add_dependencies(solverd_tests neon_twins)

if(LAPPET_QEMU_AARCH64)
  add_test(NAME neon_twins COMMAND "${LAPPET_QEMU_AARCH64}" "${neon_directory}/neon_twins")
  set_tests_properties(neon_twins PROPERTIES TIMEOUT 300)
endif()
