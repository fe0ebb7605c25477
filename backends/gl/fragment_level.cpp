#include "backends/gl/fragment_level.hpp"

#include <fmt/format.h>

#include <utility>

namespace hdmbench::gl {

namespace {

constexpr GLsizei quad_vertices = 4; ///< the first ones of every buffer

/// Tiles at the border are of no special class, and other rules than the candidates' only tell the border
/// apart: programs take time to compile.
TileLists list_tiles(const Level& full, Extent extent, Alignment alignment) {
  constexpr std::size_t inside = tile_class::observed_bit | tile_class::elastic_bit;
  return classify_tiles(
      full, extent, alignment,
      {.tile = {FragmentLevel::tile_side, FragmentLevel::tile_side},
       .classes = full.rule == Rule::steps ? class_set({0, 1, 2, inside}) : class_set({inside})});
}

Activity make_activity(const Api& api, Extent grid) {
  const std::vector<GLfloat> ones(4 * grid.sites(), 1.0F);
  constexpr int cells = FragmentLevel::cells_along_a_tile;
  Activity activity{.everything = Target(api, grid, ones.data()),
                    .awake = Target(api, grid, nullptr),
                    .cells = Target(api, {grid.width * cells, grid.height * cells}, nullptr)};
  activity.awake.make_drawable();
  activity.cells.make_drawable();
  return activity;
}

} // namespace

void require_complete(const Api& api) {
  const GLenum status = api.CheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT);
  if (status != GL_FRAMEBUFFER_COMPLETE_EXT) {
    throw DeviceError(fmt::format(
        "glCheckFramebufferStatusEXT: 0x{:04x} (this driver cannot render to float rectangle textures)",
        status));
  }
}

Target::Target(const Api& api, Extent extent, const GLfloat* pixels)
    : api_(&api), texture_(api), extent_(extent) {
  api.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture_.name());
  api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  api.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, extent.width, extent.height, 0, GL_RGBA,
                 GL_FLOAT, pixels);
}

void Target::bind(GLint unit) const {
  api_->ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  api_->BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture_.name());
}

void Target::make_drawable() {
  framebuffer_.emplace(*api_);
  draw_into();
  api_->FramebufferTexture2DEXT(GL_FRAMEBUFFER_EXT, GL_COLOR_ATTACHMENT0_EXT, GL_TEXTURE_RECTANGLE_ARB,
                                texture_.name(), 0);
  require_complete(*api_);
}

void Target::draw_into() const {
  api_->BindFramebufferEXT(GL_FRAMEBUFFER_EXT, framebuffer_->name());
}

void Target::upload(const GLfloat* pixels) const {
  api_->BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture_.name());
  api_->TexSubImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, 0, 0, extent_.width, extent_.height, GL_RGBA, GL_FLOAT,
                      pixels);
}

FragmentLevel::FragmentLevel(const Api& api, Level header_, const Level& full, Alignment alignment,
                             const GLfloat* observation_, const GLfloat* confidence_, bool with_activity)
    : header(std::move(header_)), grid(tiles_of(header.extent, {tile_side, tile_side})),
      observation(api, header.extent, observation_), confidence(api, header.extent, confidence_),
      api_(&api), images_{Target(api, header.extent, nullptr), Target(api, header.extent, nullptr)},
      vertices_(api) {
  const TileLists lists = list_tiles(full, header.extent, alignment);
  std::vector<GLfloat> corners{-1, -1, 1, -1, -1, 1, 1, 1};
  for (const std::uint32_t tile : lists.list) {
    corners.push_back(static_cast<GLfloat>(tile % static_cast<std::uint32_t>(grid.width)));
    corners.push_back(static_cast<GLfloat>(tile / static_cast<std::uint32_t>(grid.width)));
  }
  for (std::size_t tile_class = 0; tile_class < class_count; ++tile_class) {
    if (lists.count[tile_class] > 0) {
      draws.push_back({.tile_class = tile_class,
                       .first = quad_vertices + static_cast<GLint>(lists.first[tile_class]),
                       .count = static_cast<GLsizei>(lists.count[tile_class])});
    }
  }
  api.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  api.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(GLfloat)), corners.data(),
                 GL_STATIC_DRAW);
  for (Target& image : images_) {
    image.make_drawable();
  }
  if (with_activity) {
    activity = make_activity(api, grid);
  }
}

void FragmentLevel::bind_vertices() const {
  api_->BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  api_->EnableVertexAttribArray(0);
  api_->VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void FragmentLevel::draw_quad(Extent pixels) const {
  api_->Viewport(0, 0, pixels.width, pixels.height);
  api_->DrawArrays(GL_TRIANGLE_STRIP, 0, quad_vertices);
}

void FragmentLevel::prepare_tiles(int side) const {
  api_->Viewport(0, 0, grid.width * side, grid.height * side);
  api_->PointSize(static_cast<GLfloat>(side));
}

void FragmentLevel::draw_tiles(const Draw& draw) const {
  api_->DrawArrays(GL_POINTS, draw.first, draw.count);
}

void FragmentLevel::draw_all_tiles() const {
  api_->DrawArrays(GL_POINTS, quad_vertices, static_cast<GLsizei>(grid.sites()));
}

} // namespace hdmbench::gl
