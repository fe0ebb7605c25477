# cmake -DSOURCE=DIR -DOUTPUT=HEADER -P commit.cmake: the commit that is being built; "-dirty" if files differ from it.
find_package(Git QUIET)
set(commit "unknown")
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} describe --always --dirty --abbrev=12
                  OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE status ERROR_QUIET)
  if(status EQUAL 0)
    set(commit "${found}")
  endif()
endif()
set(text "#pragma once\n#include <string_view>\nnamespace hdmbench::build {\n\
inline constexpr std::string_view commit = \"${commit}\";\n}\n")
set(old "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" old)
endif()
if(NOT old STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
