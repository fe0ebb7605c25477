# cmake -DINPUT=FILE -DOUTPUT=HEADER -DNAME=IDENTIFIER [-DBYTES=ON] -P embed.cmake: a text file as a C++ string_view, or
# any file as an array of bytes.
if(BYTES)
  file(READ "${INPUT}" bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  file(WRITE "${OUTPUT}" "#pragma once\nnamespace hdmbench::sources {\n\
inline constexpr unsigned char ${NAME}[] = {${bytes}};\n}\n")
  return()
endif()
file(READ "${INPUT}" text)
file(WRITE "${OUTPUT}" "#pragma once\n#include <string_view>\nnamespace hdmbench::sources {\n\
inline constexpr std::string_view ${NAME} = R\"GLSL(${text})GLSL\";\n}\n")
