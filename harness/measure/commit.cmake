# cmake -DSOURCE=DIR -DOUTPUT=HEADER -P commit.cmake: the commit that is being built; "-dirty" if files differ from it; and those
# before it, which tell how old results are.
find_package(Git QUIET)
set(commit "unknown")
set(history "")
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} describe --always --dirty --abbrev=12
                  OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE status ERROR_QUIET)
  if(status EQUAL 0)
    set(commit "${found}")
    execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} log -1000 --format=%h --abbrev=12
                    OUTPUT_VARIABLE history OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    string(REPLACE "\n" " " history "${history}")
  endif()
endif()
set(text "#pragma once\n#include <string_view>\nnamespace hdmbench::build {\n\
inline constexpr std::string_view commit = \"${commit}\";\n\
inline constexpr std::string_view history = \"${history}\"; // newest first, 12 characters each\n}\n")
set(old "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" old)
endif()
if(NOT old STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
