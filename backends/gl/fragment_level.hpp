#pragma once

#include "backends/gl/objects.hpp"
#include "backends/session/level_arrays.hpp"
#include "backends/shared/tiles.hpp"

#include <array>
#include <optional>
#include <vector>

namespace hdmbench::gl {

/// How many slices of a volume lie side by side in a texture: so many that its longer side is as short as can
/// be. An image is one slice.
[[nodiscard]] int slices_side_by_side(Extent volume);
/// The texture of all slices.
[[nodiscard]] Extent texture_of(Extent volume);

/// A texel of a texture.
struct Texel {
  GLint x = 0;
  GLint y = 0;
};

/// A float RGBA rectangle texture of an image, or of the slices of a volume, that can be fetched from and,
/// once make_drawable() was called, drawn into.
class Target {
public:
  /// `pixels`: 4 floats each, slice after slice, or null.
  Target(const Api& api, Extent extent, const GLfloat* pixels);

  [[nodiscard]] Extent extent() const { return extent_; }
  /// Where the slice begins.
  [[nodiscard]] Texel corner(int slice) const;
  /// Sets the uniform `slices` of the program in use (kernels/shaders/slices.glsl).
  void tell_slices(GLint location) const;
  void bind(GLint unit) const;
  /// Makes a framebuffer of it. Throws DeviceError if the driver cannot.
  void make_drawable();
  /// make_drawable() must have been called.
  void draw_into() const;
  void upload(const GLfloat* pixels) const;
  /// The pixels of `sites`, the first of which has so many texels before it along every axis.
  void read(int margin, Extent sites, GLfloat* pixels) const;

private:
  const Api* api_;
  Texture texture_;
  std::optional<Framebuffer> framebuffer_;
  Extent extent_;
  int across_; ///< slices
};

/// Throws DeviceError unless the framebuffer that is bound can be drawn into.
void require_complete(const Api& api);

/// A quad, for passes over whole textures.
class Quad {
public:
  explicit Quad(const Api& api);
  /// One fragment per pixel of a rectangle. Attribute 0 is then the quad's.
  void draw(Texel origin, Extent pixels) const;

private:
  const Api* api_;
  Buffer corners_;
};

/// Two planar fields of `extent` as texels of two sites: first[i], second[i], first[i + 1], second[i + 1]. Of
/// an odd width a row's last texel has zeros for the site beyond.
[[nodiscard]] std::vector<float> interleaved_pairs(const std::vector<float>& first,
                                                   const std::vector<float>& second, Extent extent);

/// What lets a level's sweeps leave out the tiles in which nothing can change, all of it on the device. Which
/// ones, is found out after sweeps 1, 2, 4, 8, 16, 24 ...: a tile is swept at most twice as often as needed.
struct Activity {
  Target awake;     ///< a texel per tile, 0: nothing can change
  Target cells;     ///< a texel per cell of a tile
  int interval = 1; ///< sweeps from the last time to the next
  int swept = 0;    ///< since the last time

  /// Counts a sweep; whether now is the time.
  [[nodiscard]] bool is_due();
};

/// What a level's fields are as textures. Texels of one site are the thesis's (Tab. 6.1, 6.2): for rules
/// other than the candidates', whose programs need more of a site, for volumes, and on devices like its own.
struct Texels {
  int columns = 1; ///< sites side by side in a texel of the image: 1 or 2

  /// Texels of an image of so many sites; the last column's second site may be beyond it.
  [[nodiscard]] constexpr Extent of(Extent sites) const {
    return {(sites.width + columns - 1) / columns, sites.height, sites.depth};
  }
};

/// The constants of a level's sites, as the samplers of its sweep have them.
struct Constants {
  Target observation;              ///< a texel per site
  Target second;                   ///< texels: confidence, or of pairs material
  std::optional<Target> inputs;    ///< a texel per site; none where the energy has none
  std::optional<Target> curvature; ///< its inverse, of a volume whose rule needs it
};

/// What a level has on the device.
class FragmentLevel {
public:
  /// Texels a side of a tile. As large as the bins of Mesa's rasterizer: with 32 a dense sweep of an image
  /// all of whose sites are observed took a third longer there. Older devices' points end at 64 pixels.
  static constexpr int tile_side = 64;
  static constexpr int cells_along_a_tile = 4;
  /// Texels a side of the points along the image's border. Only there the border rule has to be followed: all
  /// tiles are drawn as if they were inside, and these points over them.
  static constexpr int border_side = 4;

  /// Points of one class of tiles: first ... first + count - 1 of the buffer, `side` texels large.
  struct Draw {
    std::size_t tile_class = general_class;
    int side = tile_side;
    GLint first = 0;
    GLsizei count = 0;
  };

  /// `observation` and `second` as Constants has them.
  FragmentLevel(const Api& api, const Level& level, Texels texels, const GLfloat* observation,
                const GLfloat* second, bool with_activity);

  /// The canvas is now one of whole tiles of `side` pixels, and attribute 0 is that of their points.
  void prepare_tiles(int side) const;
  /// On a canvas of tiles of tile_side.
  void draw_points(const Draw& draw) const;
  /// All tiles, whatever their class, of `side` pixels.
  void draw_all_tiles(int side) const;

  [[nodiscard]] Target& now() { return images_[current_]; }
  [[nodiscard]] Target& other() { return images_[1 - current_]; }
  void swap() { current_ = 1 - current_; }
  /// Nothing is known any more of what the sweep before changed.
  void wake_all();

  const Level header; ///< without its fields
  const Texels texels;
  const Extent grid; ///< tiles
  Constants constants;
  std::vector<Draw> draws; ///< in this order; of a volume one, which has no points but is drawn by slices
  std::optional<Activity> activity;

private:
  const Api* api_;
  std::array<Target, 2> images_;
  std::size_t current_ = 0;
  Buffer vertices_;
};

} // namespace hdmbench::gl
