#pragma once

#include <filesystem>

namespace hdmbench::images {

/// ITK 5.2 does not survive damaged PNG and JPEG files (libpng aborts, JPEGImageIO frees what it never had),
/// nor headers of MetaImage, NIfTI and TIFF that make no sense (it writes beyond its memory, ends the
/// program, or never ends), and takes missing NIfTI pixels for zeros and missing MetaImage pixels for
/// whatever the memory held. Throws InputError for such a file; to be called before ITK sees it. Files of
/// other formats pass: there ITK notices.
void require_intact(const std::filesystem::path& file);

} // namespace hdmbench::images
