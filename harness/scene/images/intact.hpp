#pragma once

#include <filesystem>

namespace hdmbench::images {

/// ITK 5.2 does not survive damaged PNG and JPEG files (libpng aborts, JPEGImageIO frees what it never had),
/// nor headers of MetaImage, NIfTI and TIFF that make no sense (it writes beyond its memory, ends the
/// program, or never ends), and takes missing NIfTI pixels for zeros and missing MetaImage pixels for
/// whatever the memory held. Throws InputError for such a file; to be called before ITK sees it. Files of
/// other formats pass: there ITK notices.
void require_intact(const std::filesystem::path& file);

/// MetaIO believes what a MetaImage header says: a negative number of axes makes it loop for ever, a list
/// that is too short or a key that comes twice makes it write beyond its memory. Throws InputError, with the
/// line, unless every line is "Key = Value", no key comes twice, and the keys that MetaIO knows have values
/// of their type and number.
void require_sound_meta_header(const std::filesystem::path& file);

/// libtiff follows directories that lead back to themselves for ever, and asks for as much memory as an entry
/// says it needs. Throws InputError unless every directory of the TIFF or BigTIFF file is inside it, comes
/// once, and has entries that fit into the file, their texts ended by a zero (but those that libtiff ends
/// itself).
void require_sound_tiff_directories(const std::filesystem::path& file);

} // namespace hdmbench::images
