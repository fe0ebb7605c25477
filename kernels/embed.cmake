# cmake -DINPUT=FILE -DOUTPUT=HEADER -DNAME=IDENTIFIER [-DBYTES=ON] [-DFOLDER=FOLDER] -P embed.cmake: a text file as a C++
# string_view, or any file as an array of bytes. With FOLDER, which is this one, a text's #include lines are replaced by
# the files of shaders/ and specification/, but for energy.inc and law.inc, which are others for each energy and law.
if(BYTES)
  file(READ "${INPUT}" bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  file(WRITE "${OUTPUT}" "#pragma once\nnamespace hdmbench::sources {\n\
inline constexpr unsigned char ${NAME}[] = {${bytes}};\n}\n")
  return()
endif()
file(READ "${INPUT}" text)
if(FOLDER)
  string(REPLACE "#include \"energy.inc\"" "@ENERGY@" text "${text}")
  string(REPLACE "#extension GL_GOOGLE_include_directive : require\n" "" text "${text}")
  while(text MATCHES "#include \"([^\"]+)\"")
    set(line "${CMAKE_MATCH_0}")
    set(included "${FOLDER}/shaders/${CMAKE_MATCH_1}")
    if(NOT EXISTS "${included}")
      set(included "${FOLDER}/specification/${CMAKE_MATCH_1}")
    endif()
    file(READ "${included}" part)
    string(REPLACE "#include \"law.inc\"" "@LAW@" part "${part}")
    string(REPLACE "${line}" "${part}" text "${text}")
  endwhile()
  string(REPLACE "@ENERGY@" "#include \"energy.inc\"" text "${text}")
  string(REPLACE "@LAW@" "#include \"law.inc\"" text "${text}")
endif()
file(WRITE "${OUTPUT}" "#pragma once\n#include <string_view>\nnamespace hdmbench::sources {\n\
inline constexpr std::string_view ${NAME} = R\"GLSL(${text})GLSL\";\n}\n")
