#include "backends/gl/fragment_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench::gl {

namespace {

constexpr GLsizei quad_vertices = 4; ///< the first ones of every buffer

/// Other rules than the candidates' do not tell classes apart: programs take time to compile.
TileLists list_tiles(const Level& full, Extent extent, Alignment alignment, Texels texels) {
  return classify_tiles(
      full, extent, alignment,
      {.tile = {FragmentLevel::tile_side * texels.columns, FragmentLevel::tile_side},
       .classes = full.rule == Rule::steps ? class_set({0, 1, 2, 3, 4, 5, 6}) : class_set({})});
}

/// Vertices of points, and which draws they make.
struct Points {
  std::vector<GLfloat> corners;
  std::vector<FragmentLevel::Draw> draws;

  void add(std::size_t column, std::size_t row) {
    corners.push_back(static_cast<GLfloat>(column));
    corners.push_back(static_cast<GLfloat>(row));
  }
  [[nodiscard]] GLint count() const { return static_cast<GLint>(corners.size() / 2); }
};

/// Every tile once, a draw per class, as if none were at the border.
void add_tiles(Points& points, const TileLists& lists) {
  for (std::size_t tile_class = 0; tile_class < tile_class::border_bit; ++tile_class) {
    FragmentLevel::Draw draw{.tile_class = tile_class, .first = points.count()};
    for (std::size_t tile = 0; tile < lists.classes.size(); ++tile) {
      if (lists.classes[tile] % tile_class::border_bit == tile_class) {
        const auto width = static_cast<std::size_t>(lists.tiles.width);
        points.add(tile % width, tile / width);
      }
    }
    draw.count = points.count() - draw.first;
    if (draw.count > 0) {
      points.draws.push_back(draw);
    }
  }
}

/// Along the border of an image of so many texels.
void add_border(Points& points, Extent texels) {
  constexpr int side = FragmentLevel::border_side;
  const Extent grid = tiles_of(texels, {side, side});
  FragmentLevel::Draw draw{.side = side, .first = points.count()};
  for (int y = 0; y < grid.height; ++y) {
    const bool whole_row = y == 0 || y == grid.height - 1;
    for (int x = 0; x < grid.width; x += whole_row ? 1 : std::max(grid.width - 1, 1)) {
      points.add(static_cast<std::size_t>(x), static_cast<std::size_t>(y));
    }
  }
  draw.count = points.count() - draw.first;
  if (static_cast<std::size_t>(draw.count) == grid.sites()) {
    points.draws.clear(); // they would be drawn over
  }
  points.draws.push_back(draw);
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
                             Texels texels_, const GLfloat* observation, const GLfloat* second,
                             bool with_activity)
    : header(std::move(header_)), texels(texels_),
      grid(tiles_of(texels.of(header.extent), {tile_side, tile_side})),
      constants{.observation = Target(api, header.extent, observation),
                .second = Target(api, texels.of(header.extent), second)},
      api_(&api), images_{Target(api, texels.of(header.extent), nullptr),
                          Target(api, texels.of(header.extent), nullptr)},
      vertices_(api) {
  Points points{.corners = {-1, -1, 1, -1, -1, 1, 1, 1}, .draws = {}};
  add_tiles(points, list_tiles(full, header.extent, alignment, texels));
  add_border(points, texels.of(header.extent));
  draws = points.draws;
  api.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  api.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(points.corners.size() * sizeof(GLfloat)),
                 points.corners.data(), GL_STATIC_DRAW);
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
}

void FragmentLevel::draw_points(const Draw& draw) const {
  api_->PointSize(static_cast<GLfloat>(draw.side));
  api_->DrawArrays(GL_POINTS, draw.first, draw.count);
}

void FragmentLevel::draw_all_tiles(int side) const {
  api_->PointSize(static_cast<GLfloat>(side));
  api_->DrawArrays(GL_POINTS, quad_vertices, static_cast<GLsizei>(grid.sites()));
}

} // namespace hdmbench::gl
