# CHOLMOD and UMFPACK as SuiteSparse::cholmod and SuiteSparse::umfpack. SuiteSparse before 7 has no configuration
# files of its own; this one is installed beside hdmbench's.
include(FindPackageHandleStandardArgs)
find_path(SuiteSparse_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(SuiteSparse_CHOLMOD_LIBRARY cholmod)
find_library(SuiteSparse_UMFPACK_LIBRARY umfpack)
mark_as_advanced(SuiteSparse_INCLUDE_DIR SuiteSparse_CHOLMOD_LIBRARY SuiteSparse_UMFPACK_LIBRARY)
find_package_handle_standard_args(SuiteSparse
  REQUIRED_VARS SuiteSparse_CHOLMOD_LIBRARY SuiteSparse_UMFPACK_LIBRARY SuiteSparse_INCLUDE_DIR)
if(SuiteSparse_FOUND)
  foreach(part CHOLMOD UMFPACK)
    string(TOLOWER ${part} name)
    if(NOT TARGET SuiteSparse::${name})
      add_library(SuiteSparse::${name} UNKNOWN IMPORTED)
      set_target_properties(SuiteSparse::${name} PROPERTIES IMPORTED_LOCATION ${SuiteSparse_${part}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${SuiteSparse_INCLUDE_DIR})
    endif()
  endforeach()
endif()
