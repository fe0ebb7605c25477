#include "backends/gl/fragment_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench::gl {

namespace {

/// Other rules than the candidates' do not tell classes apart: programs take time to compile.
TileLists list_tiles(const Level& level, Texels texels) {
  return classify_tiles(
      level, level.extent, Alignment::corner,
      {.tile = {FragmentLevel::tile_side * texels.columns, FragmentLevel::tile_side},
       .classes = level.rule == Rule::steps ? classes_inside | class_set({4, 5, 6}) : class_set({})});
}

/// Vertices of points, and which draws they make.
struct Points {
  std::vector<GLfloat> corners;
  std::vector<FragmentLevel::Draw> draws;

  void add(int column, int row) {
    corners.push_back(static_cast<GLfloat>(column));
    corners.push_back(static_cast<GLfloat>(row));
  }
  [[nodiscard]] GLint count() const { return static_cast<GLint>(corners.size() / 2); }
  /// Of the points from draw.first on, if there are any.
  void add_draw(FragmentLevel::Draw draw) {
    draw.count = count() - draw.first;
    if (draw.count > 0) {
      draws.push_back(draw);
    }
  }
};

/// Every tile once, a draw per class, as if none were at the border.
void add_tiles(Points& points, const TileLists& lists) {
  for (std::size_t known = 0; known < tile_class::border_bit; ++known) {
    const FragmentLevel::Draw draw{.tile_class = known, .first = points.count()};
    for (int y = 0; y < lists.tiles.height; ++y) {
      for (int x = 0; x < lists.tiles.width; ++x) {
        if (lists.classes[lists.tiles.index(x, y)] % tile_class::border_bit == known) {
          points.add(x, y);
        }
      }
    }
    points.add_draw(draw);
  }
}

/// Along the border of an image of so many texels, by the class of the tile that they are part of.
void add_border(Points& points, const TileLists& lists, Extent texels) {
  constexpr int side = FragmentLevel::border_side;
  constexpr int along_a_tile = FragmentLevel::tile_side / side;
  const Extent grid = tiles_of(texels, {side, side});
  const bool is_everything = grid.width <= 2 || grid.height <= 2;
  if (is_everything) { // one draw is enough
    points.draws.clear();
  }
  for (std::size_t known = 0; known < tile_class::border_bit; ++known) {
    FragmentLevel::Draw draw{
        .tile_class = known | tile_class::border_bit, .side = side, .first = points.count()};
    for (int y = 0; y < grid.height; ++y) {
      const bool whole_row = y == 0 || y == grid.height - 1;
      for (int x = 0; x < grid.width; x += whole_row ? 1 : std::max(grid.width - 1, 1)) {
        const std::size_t tile = lists.tiles.index(x / along_a_tile, y / along_a_tile);
        const std::size_t drawn_as =
            is_everything ? general_class : lists.classes[tile] | tile_class::border_bit;
        if (drawn_as == draw.tile_class) {
          points.add(x, y);
        }
      }
    }
    points.add_draw(draw);
  }
}

std::optional<Target> make_curvature(const Api& api, const Level& level) {
  if (level.extent.axes() == 2 || !needs_inverse_curvature(level.rule)) {
    return std::nullopt;
  }
  const VectorField& of = level.inverse_curvature;
  return Target(api, level.extent, interleaved({of[0], of[1], of[2], {}}).data());
}

std::optional<Target> make_inputs(const Api& api, const Level& level) {
  if (level.inputs.empty()) {
    return std::nullopt;
  }
  std::vector<std::span<const float>> planes(4);
  std::ranges::transform(level.inputs, planes.begin(), &ScalarField::values);
  return Target(api, level.extent, interleaved(planes).data());
}

Activity make_activity(const Api& api, Extent grid) {
  constexpr int cells = FragmentLevel::cells_along_a_tile;
  Activity activity{.awake = Target(api, grid, nullptr),
                    .cells = Target(api, {grid.width * cells, grid.height * cells}, nullptr)};
  activity.awake.make_drawable();
  activity.cells.make_drawable();
  return activity;
}

} // namespace

bool Activity::is_due() {
  // A change spreads by a site in a sweep, and tiles are awake from the distance of a cell on (wake.frag).
  constexpr int longest = 8;
  static_assert(longest <= FragmentLevel::tile_side / FragmentLevel::cells_along_a_tile);
  if (++swept < interval) {
    return false;
  }
  swept = 0;
  interval = std::min(2 * interval, longest);
  return true;
}

void require_complete(const Api& api) {
  const GLenum status = api.CheckFramebufferStatusEXT(GL_FRAMEBUFFER_EXT);
  if (status != GL_FRAMEBUFFER_COMPLETE_EXT) {
    throw DeviceError(fmt::format(
        "glCheckFramebufferStatusEXT: 0x{:04x} (this driver cannot render to float rectangle textures)",
        status));
  }
}

int slices_side_by_side(Extent volume) {
  const auto longer_side = [&](int across) {
    return std::max(across * volume.width, (volume.depth + across - 1) / across * volume.height);
  };
  int best = 1;
  for (int across = 2; across <= volume.depth; ++across) {
    best = longer_side(across) < longer_side(best) ? across : best;
  }
  return best;
}

Extent texture_of(Extent volume) {
  const int across = slices_side_by_side(volume);
  return {across * volume.width, (volume.depth + across - 1) / across * volume.height};
}

Target::Target(const Api& api, Extent extent, const GLfloat* pixels)
    : api_(&api), texture_(api), extent_(extent), across_(slices_side_by_side(extent)) {
  api.BindTexture(GL_TEXTURE_RECTANGLE_ARB, texture_.name());
  api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  api.TexParameteri(GL_TEXTURE_RECTANGLE_ARB, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  const Extent texture = texture_of(extent);
  api.TexImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, GL_RGBA32F_ARB, texture.width, texture.height, 0, GL_RGBA,
                 GL_FLOAT, extent.depth == 1 ? pixels : nullptr);
  if (extent.depth > 1 && pixels != nullptr) {
    upload(pixels);
  }
}

Texel Target::corner(int slice) const {
  return {slice % across_ * extent_.width, slice / across_ * extent_.height};
}

void Target::tell_slices(GLint location) const {
  api_->Uniform3f(location, static_cast<GLfloat>(extent_.width), static_cast<GLfloat>(extent_.height),
                  static_cast<GLfloat>(across_));
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
  for (int slice = 0; slice < extent_.depth; ++slice) {
    const Texel first = corner(slice);
    api_->TexSubImage2D(GL_TEXTURE_RECTANGLE_ARB, 0, first.x, first.y, extent_.width, extent_.height, GL_RGBA,
                        GL_FLOAT, pixels + 4 * extent_.index(0, 0, slice));
  }
}

void Target::read(int margin, Extent sites, GLfloat* pixels) const {
  draw_into();
  for (int slice = 0; slice < sites.depth; ++slice) {
    const Texel first = corner(extent_.depth > 1 ? slice + margin : 0);
    api_->ReadPixels(first.x + margin, first.y + margin, sites.width, sites.height, GL_RGBA, GL_FLOAT,
                     pixels + 4 * sites.index(0, 0, slice));
  }
}

Quad::Quad(const Api& api) : api_(&api), corners_(api) {
  static constexpr std::array<GLfloat, 8> corners{-1, -1, 1, -1, -1, 1, 1, 1};
  api.BindBuffer(GL_ARRAY_BUFFER, corners_.name());
  api.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners.data(), GL_STATIC_DRAW);
}

void Quad::draw(Texel origin, Extent pixels) const {
  api_->Viewport(origin.x, origin.y, pixels.width, pixels.height);
  api_->BindBuffer(GL_ARRAY_BUFFER, corners_.name());
  api_->EnableVertexAttribArray(0);
  api_->VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
  api_->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

std::vector<float> interleaved_pairs(const std::vector<float>& first, const std::vector<float>& second,
                                     Extent extent) {
  const std::size_t pitch = 4 * static_cast<std::size_t>((extent.width + 1) / 2);
  std::vector<float> texels(pitch * static_cast<std::size_t>(extent.height));
  for (int y = 0; y < extent.height; ++y) {
    std::size_t at = static_cast<std::size_t>(y) * pitch;
    for (std::size_t i = extent.index(0, y); i < extent.index(0, y + 1); ++i) {
      texels[at++] = first[i];
      texels[at++] = second[i];
    }
  }
  return texels;
}

FragmentLevel::FragmentLevel(const Api& api, const Level& level, Texels texels_, const GLfloat* observation,
                             const GLfloat* second, bool with_activity)
    : header(without_fields(level)), texels(texels_),
      grid(tiles_of(texels.of(header.extent), {tile_side, tile_side})),
      constants{.observation = Target(api, header.extent, observation),
                .second = Target(api, texels.of(header.extent), second),
                .inputs = make_inputs(api, level),
                .curvature = make_curvature(api, level)},
      api_(&api), images_{Target(api, texels.of(header.extent), nullptr),
                          Target(api, texels.of(header.extent), nullptr)},
      vertices_(api) {
  Points points;
  if (header.extent.axes() == 3) {
    points.draws.emplace_back();
  } else {
    const TileLists lists = list_tiles(level, texels);
    add_tiles(points, lists);
    add_border(points, lists, texels.of(header.extent));
  }
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

void FragmentLevel::wake_all() {
  if (activity) {
    activity->awake.upload(std::vector<GLfloat>(4 * grid.sites(), 1.0F).data());
    activity->interval = 1;
    activity->swept = 0;
  }
}

void FragmentLevel::prepare_tiles(int side) const {
  api_->Viewport(0, 0, grid.width * side, grid.height * side);
  api_->BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  api_->EnableVertexAttribArray(0);
  api_->VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void FragmentLevel::draw_points(const Draw& draw) const {
  api_->PointSize(static_cast<GLfloat>(draw.side));
  api_->DrawArrays(GL_POINTS, draw.first, draw.count);
}

void FragmentLevel::draw_all_tiles(int side) const {
  api_->PointSize(static_cast<GLfloat>(side));
  api_->DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(grid.sites()));
}

} // namespace hdmbench::gl
