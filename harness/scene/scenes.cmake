# cmake "-DSCENES=a.toml;b.toml" -DFOLDER=DIR -DNAMES=scene_texts -DOUTPUT=HEADER -P scenes.cmake: shipped files as one table, in
# a namespace of that name.
set(rows "")
foreach(scene IN LISTS SCENES)
  file(READ "${FOLDER}/${scene}" text)
  string(REGEX REPLACE "\\.toml$" "" name "${scene}")
  string(APPEND rows "    Text{\"${name}\", R\"TOML(${text})TOML\"},\n")
endforeach()
list(LENGTH SCENES count)
file(WRITE "${OUTPUT}" "#pragma once\n#include <array>\n#include <string_view>\nnamespace hdmbench::${NAMES} {\n\
struct Text {\n  std::string_view name;\n  std::string_view text;\n};\n\
inline constexpr std::array<Text, ${count}> all{\n${rows}};\n}\n")
