# Yardsticks of economy: the daemon without some features (math/features.h). Only the sources that read what is left out
# are compiled for them, all else is what the daemon consists of. Built when one is asked for by name.

# Collects the sources below src/ that include a header, themselves or by way of others.
function(lappet_sources_that_include header result)
  set(root "${CMAKE_CURRENT_SOURCE_DIR}/src")
  file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE "${root}" "${root}/*.h" "${root}/*.cpp")
  foreach(file IN LISTS files)
    file(STRINGS "${root}/${file}" includes REGEX "^#include \"")
    list(TRANSFORM includes REPLACE "^#include \"(.*)\".*$" "\\1")
    set(included_by_${file} "${includes}")
  endforeach()
  set(reached "${header}")
  set(before)
  while(NOT reached STREQUAL before)
    set(before "${reached}")
    foreach(file IN LISTS files)
      foreach(include IN LISTS included_by_${file})
        if(include IN_LIST before AND NOT file IN_LIST reached)
          list(APPEND reached "${file}")
        endif()
      endforeach()
    endforeach()
  endwhile()
  list(FILTER reached INCLUDE REGEX "\\.cpp$")
  list(TRANSFORM reached PREPEND "${root}/")
  set(${result} "${reached}" PARENT_SCOPE)
endfunction()

# lappet_yardstick(NAME feature...): the program lappet-solverd-NAME, which is without the features. Of the kernels that
# goes for one instruction set, which callgrind knows; the others are the whole daemon's.
function(lappet_yardstick name)
  lappet_sources_that_include(math/features.h sources)
  lappet_of_this_platform(sources)
  lappet_instruction_set_flags(sources)
  list(FILTER sources EXCLUDE REGEX "_(sse42|avx512|scalar)\\.cpp$")
  list(JOIN ARGN "," left_out)
  add_executable(lappet-solverd-${name} EXCLUDE_FROM_ALL "${main_file}" ${sources})
  target_compile_definitions(lappet-solverd-${name} PRIVATE LAPPET_LEFT_OUT="${left_out}")
  # The linker takes from the libraries only what these sources do not have.
  target_link_libraries(lappet-solverd-${name} PRIVATE lappet_server CLI11::CLI11)
  set_target_properties(lappet-solverd-${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
endfunction()

lappet_yardstick(plain contact fibers muscle prestretch heterogeneity mesh_cells landmarks error_estimate strain)
lappet_yardstick(fibers contact muscle prestretch heterogeneity mesh_cells)
