#include "backends/gl/fragment.hpp"
#include "backends/gl/fragment_level.hpp"
#include "backends/session/elastic_level_session.hpp"

#include <fmt/format.h>
#include <shaders/elastic_fragment.hpp>
#include <shaders/quad_vertex.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>

namespace hdmbench::gl {

namespace {

/// Texture units of the samplers of elastic.frag, the first one of those that are arrays.
enum Unit : GLint { from, second, matrices, moments, response = moments + 6 };

/// One kernel, and where its uniforms are.
struct ElasticProgram {
  ElasticProgram(const Api& api, const ElasticKernel& kernel, std::size_t axes)
      : program(api, {{GL_VERTEX_SHADER, std::string(sources::quad_vertex)},
                      {GL_FRAGMENT_SHADER, elastic_fragment_text(kernel, axes)}}),
        extent(program.uniform("extent")), numbers(program.uniform("numbers")),
        law(program.uniform("law_told")), from_slices(program.uniform("from_slices")),
        second_slices(program.uniform("second_slices")), to_slices(program.uniform("to_slices")),
        slice(program.uniform("slice")) {
    program.use();
    std::array<GLint, 8> units{};
    std::iota(units.begin(), units.end(), GLint{moments});
    api.Uniform1i(program.uniform("from"), from);
    api.Uniform1i(program.uniform("second"), second);
    api.Uniform1i(program.uniform("matrices"), matrices);
    api.Uniform1iv(program.uniform("moments"), response - moments, units.data());
    api.Uniform1iv(program.uniform("response"), 2, units.data() + response - moments);
  }

  Program program;
  GLint extent;
  GLint numbers;
  GLint law;
  GLint from_slices; ///< this and what follows -1 in an image
  GLint second_slices;
  GLint to_slices;
  GLint slice;
};

/// One number of every site of a level, in its RingedGrid; null: 0.
using Numbers = const std::vector<float>*;

/// Textures of numbers, four in each in turn.
std::vector<Target> textures_of(const Api& api, const RingedGrid& grid, const std::vector<Numbers>& numbers) {
  const Extent padded = ElasticLayout::padded(grid.sites);
  std::vector<Target> textures;
  for (std::size_t first = 0; first < numbers.size(); first += 4) {
    std::vector<GLfloat> texels(4 * padded.sites());
    for (std::size_t i = first; i < std::min(first + 4, numbers.size()); ++i) {
      if (numbers[i] != nullptr) {
        lay_out(grid, *numbers[i], ElasticLayout::alone(grid.sites), texels.data() + i % 4, 4);
      }
    }
    textures.emplace_back(api, padded, texels.data());
  }
  return textures;
}

/// The textures of a level, as elastic.frag has them.
struct LevelTextures {
  /// `slots`: how many; `matrices_before`: how many masked cells the levels before have.
  LevelTextures(const Api& api, const ElasticLevel& level, std::size_t matrices_before, int slots) {
    const auto append = [](std::vector<Numbers>& to, const std::vector<std::vector<float>>& arrays) {
      std::ranges::transform(arrays, std::back_inserter(to), [](const auto& array) { return &array; });
    };
    std::vector<Numbers> of_cells;
    std::vector<Numbers> of_sites;
    append(of_sites, level.response);
    if (level.moments.size() == 1) { // moduli of the sites of a volume
      append(of_sites, level.moments);
    } else {
      append(of_cells, level.moments);
      of_sites.resize(level.grid.axes() == 3 ? 7 : 3);
    }
    std::vector<float> masked(level.grid.size());
    const Extent cells = level.grid.cells();
    for (int row = 0; row < cells.rows(); ++row) {
      const int y = row % cells.height;
      const int z = row / cells.height;
      const auto [first, last] = level.masked.row(y, z);
      for (std::size_t i = first; i < last; ++i) {
        masked[level.grid.index(level.masked.x[i], y, z)] = static_cast<float>(matrices_before + i + 1);
      }
    }
    of_sites.push_back(&masked);
    moments = textures_of(api, level.grid, of_cells);
    response = textures_of(api, level.grid, of_sites);
    const Extent padded = ElasticLayout::padded(level.grid.sites);
    const std::vector<GLfloat> zeros(4 * padded.sites());
    for (int i = 0; i < slots; ++i) {
      fields.emplace_back(api, padded, zeros.data()).make_drawable();
    }
  }

  std::vector<Target> moments;
  std::vector<Target> response;
  std::vector<Target> fields; ///< by slot
};

class ElasticFragment {
public:
  static constexpr int block = 2;
  static constexpr bool has_laws = false; // a cell is more than its card has room for

  explicit ElasticFragment(const Context& context) : gl_(context.api()), quad_(gl_) {}

  static std::int64_t coarse_size() { return 0; }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    const std::vector<float> table = elastic_matrices(hierarchy);
    axes_ = layout.levels.front().sites.axes();
    const int width = elastic_matrices_width(axes_);
    const Extent table_extent{width, static_cast<int>(table.size() / 4 / static_cast<std::size_t>(width))};
    require_fits(layout.levels.front().sites, table_extent);
    levels_.clear();
    sums_.clear();
    std::size_t matrices_before = 0;
    for (const ElasticLevel& level : hierarchy.levels) {
      levels_.emplace_back(gl_, level, matrices_before,
                           levels_.empty() ? elastic_slots : elastic_slots_on_levels);
      matrices_before += level.masked.x.size();
    }
    for (int i = 0; i < 2; ++i) {
      sums_.emplace_back(gl_, layout.sums.sites, nullptr).make_drawable();
    }
    matrices_.emplace(gl_, table_extent, table.data());
    load_inverse(hierarchy);
  }

  void write(ElasticArray to, const VectorField& values) {
    const ElasticLayout::Part part = ElasticLayout::alone(values.extent);
    pixels_.assign(4 * ElasticLayout::padded(values.extent).sites(), 0.0F);
    for (int row = 0; row < values.extent.rows(); ++row) {
      const int y = row % values.extent.height;
      const int z = row / values.extent.height;
      auto at = static_cast<std::size_t>(4 * (part.first + z * part.layer + y * part.pitch));
      for (std::size_t i = values.extent.index(0, row); i < values.extent.index(0, row + 1); ++i, at += 4) {
        for (std::size_t axis = 0; axis < axes_; ++axis) {
          pixels_[at + axis] = values[axis][i];
        }
      }
    }
    texture(to).upload(pixels_.data());
  }

  void read(ElasticArray array, VectorField& values) {
    pixels_.resize(4 * values.extent.sites());
    texture(array).read(1, values.extent, pixels_.data());
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      for (std::size_t i = 0; i < values[axis].size(); ++i) {
        values[axis][i] = pixels_[4 * i + axis];
      }
    }
  }

  [[nodiscard]] float read_sum(ElasticArray array) {
    std::array<GLfloat, 4> pixel{};
    texture(array).read(0, {1, 1}, pixel.data());
    return pixel.front();
  }

  void run(std::span<const ElasticWork> work) {
    timer_([&] {
      for (const ElasticWork& piece : work) {
        run(std::get<ElasticCall>(piece));
      }
    });
  }

  std::optional<double> device_seconds() { return timer_.device_seconds(); }

private:
  void run(const ElasticCall& call) {
    const ElasticProgram& kernel = compiled(call.kernel);
    const ElasticParameters& p = call.parameters;
    kernel.program.use();
    const Target& to = texture(call.to);
    const auto width = static_cast<GLfloat>(p.from.width);
    const auto height = static_cast<GLfloat>(p.from.height);
    if (axes_ == 3) {
      gl_.Uniform3f(kernel.extent, width, height, static_cast<GLfloat>(p.from.depth));
      texture(call.from).tell_slices(kernel.from_slices);
      texture(call.second).tell_slices(kernel.second_slices);
      to.tell_slices(kernel.to_slices);
    } else {
      gl_.Uniform2f(kernel.extent, width, height);
    }
    gl_.Uniform4f(kernel.law, p.law[0], p.law[1], p.law[2], p.bend);
    gl_.Uniform4f(kernel.numbers, p.factor, 0.0F, 0.0F, 0.0F);
    const LevelTextures& constants = levels_.at(static_cast<std::size_t>(call.from.level));
    texture(call.from).bind(from);
    texture(call.second).bind(second);
    bind_all(constants.moments, moments);
    bind_all(constants.response, response);
    (call.kernel.step == ElasticStep::solve ? *inverse_ : *matrices_).bind(matrices);
    to.draw_into();
    const GLint margin = call.to.slot < elastic_slots ? 1 : 0;
    for (int z = 0; z < p.to.depth; ++z) {
      const int slice = to.extent().depth > 1 ? z + margin : 0;
      const Texel corner = to.corner(slice);
      gl_.Uniform1f(kernel.slice, static_cast<GLfloat>(slice));
      quad_.draw({corner.x + margin, corner.y + margin}, {p.to.width, p.to.height});
    }
  }

  static void bind_all(const std::vector<Target>& textures, GLint unit) {
    for (const Target& one : textures) {
      one.bind(unit++);
    }
  }

  [[nodiscard]] Target& texture(ElasticArray array) {
    return array.slot < elastic_slots ? levels_.at(static_cast<std::size_t>(array.level))
                                            .fields.at(static_cast<std::size_t>(array.slot))
                                      : sums_.at(static_cast<std::size_t>(array.slot - elastic_sums));
  }

  void require_fits(Extent sites, Extent table) const {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    const Extent texture = texture_of(ElasticLayout::padded(sites));
    if (std::max({texture.width, texture.height, table.width, table.height}) > limit) {
      throw TooLarge(
          fmt::format("{} sites need textures of {} for the elastic energy, and one of {} for cells "
                      "beside conditions; this device's rectangle textures end at {} x {}",
                      sites.text(), texture.text(), table.text(), limit, limit));
    }
  }

  void load_inverse(const ElasticHierarchy& hierarchy) {
    const auto sites = static_cast<int>(hierarchy.levels.back().grid.sites.sites());
    const std::vector<float>& numbers = hierarchy.coarsest_inverse;
    std::vector<GLfloat> texels(4 * (numbers.size() / axes_));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      texels[4 * (i / axes_) + i % axes_] = numbers[i];
    }
    inverse_.emplace(gl_, Extent{sites, static_cast<int>(axes_) * sites}, texels.data());
  }

  const ElasticProgram& compiled(const ElasticKernel& kernel) {
    return programs_[axes_ - 2].try_emplace(kernel, gl_, kernel, axes_).first->second;
  }

  const Api& gl_;
  Quad quad_;
  Timer timer_{gl_};
  std::size_t axes_ = 2;
  std::vector<LevelTextures> levels_;
  std::vector<Target> sums_;
  std::optional<Target> matrices_; ///< elastic_matrices()
  std::optional<Target> inverse_;
  std::array<std::map<ElasticKernel, ElasticProgram>, 2> programs_; ///< of images and of volumes
  std::vector<GLfloat> pixels_;                                     ///< RGBA staging
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_fragment(std::string name, std::unique_ptr<Context> context) {
  return std::make_unique<ElasticLevelSession<Context, ElasticFragment>>(std::move(name), std::move(context));
}

std::string elastic_fragment_text(const ElasticKernel& kernel, std::size_t axes) {
  return assemble(sources::elastic_fragment,
                  fmt::format("#define STEP {:d}\n#define HAS_LOAD {:d}\n#define IS_IMAGE {:d}\n"
                              "#define HAS_MASKED {:d}\n#define BOXES {:d}\n#define HDM_AXES {}\n"
                              "#define HALVED_X {}\n#define HALVED_Y {}\n#define HALVED_Z {}\n",
                              static_cast<int>(kernel.step), kernel.has_load, kernel.is_image,
                              kernel.has_masked, kernel.has_boxes, axes, kernel.halved & 1,
                              kernel.halved >> 1 & 1, kernel.halved >> 2));
}

} // namespace hdmbench::gl
