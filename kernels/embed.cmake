# cmake -DINPUT=FILE -DOUTPUT=HEADER -DNAME=IDENTIFIER -P embed.cmake: a text file as a C++ string_view.
file(READ "${INPUT}" text)
file(WRITE "${OUTPUT}" "#pragma once\n#include <string_view>\nnamespace hdmbench::sources {\n\
inline constexpr std::string_view ${NAME} = R\"GLSL(${text})GLSL\";\n}\n")
