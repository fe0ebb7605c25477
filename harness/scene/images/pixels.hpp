#pragma once

#include <itkMacro.h>
#include <itkVectorImage.h>

#include <filesystem>
#include <string>

/// ITK inside harness/scene/images/ only: its headers compile slowly.
namespace hdmbench::images {

/// What any readable file becomes: up to three axes (a missing one has one index), any number of components
/// per pixel.
using Pixels = itk::VectorImage<float, 3>;

/// The whole file, its values unchanged but for the rounding to float; the pixels of a flat one are as deep
/// as they are wide. Throws InputError.
[[nodiscard]] Pixels::Pointer read_pixels(const std::filesystem::path& file);

/// ITK's message on one line, without the class, the address and the empty lines around it.
[[nodiscard]] std::string own_words(const itk::ExceptionObject& error);

} // namespace hdmbench::images
