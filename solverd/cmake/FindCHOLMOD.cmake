# Finds CHOLMOD of SuiteSparse: Debian's 5.12 ships no CMake package. Defines CHOLMOD::CHOLMOD.
include(FindPackageHandleStandardArgs)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
find_library(SUITESPARSECONFIG_LIBRARY suitesparseconfig)
find_package_handle_standard_args(
  CHOLMOD
  REQUIRED_VARS CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY CHOLMOD_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "on Debian: apt-get install libsuitesparse-dev")
if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(
    CHOLMOD::CHOLMOD
    PROPERTIES IMPORTED_LOCATION "${CHOLMOD_LIBRARY}"
               INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}"
               INTERFACE_LINK_LIBRARIES "${SUITESPARSECONFIG_LIBRARY}")
  if(LAPPET_TARGET)  # a static library, which does not name its BLAS (packaging/cross/build.sh)
    find_library(CHOLMOD_BLAS_LIBRARY scipy_openblas REQUIRED)
    target_link_libraries(CHOLMOD::CHOLMOD INTERFACE "${CHOLMOD_BLAS_LIBRARY}")
  endif()
endif()
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY)
