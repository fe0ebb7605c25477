#pragma once

#include <filesystem>

namespace hdmbench::images {

/// MetaIO believes what a MetaImage header says: a negative number of axes makes it loop for ever, a list
/// that is too short or a key that comes twice makes it write beyond its memory. Throws InputError, with the
/// line, unless every line is "Key = Value", no key comes twice, and the keys that MetaIO knows have values
/// of their type and number.
void require_sound_meta_header(const std::filesystem::path& file);

} // namespace hdmbench::images
