#pragma once

#include <filesystem>

namespace hdmbench::images {

/// libtiff follows directories that lead back to themselves for ever, and asks for as much memory as an entry
/// says it needs. Throws InputError unless every directory of the TIFF or BigTIFF file is inside it, comes
/// once, and has entries that fit into the file, their texts ended by a zero (but those that libtiff ends
/// itself).
void require_sound_tiff_directories(const std::filesystem::path& file);

} // namespace hdmbench::images
