#include "backends/gl/fragment.hpp"
#include "backends/gl/fragment_level.hpp"
#include "backends/session/elastic_level_session.hpp"

#include <fmt/format.h>
#include <shaders/elastic_fragment.hpp>
#include <shaders/quad_vertex.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

namespace hdmbench::gl {

namespace {

/// Texture units of the samplers of elastic.frag.
enum Unit : GLint { from, second, moments, more, response, matrices };
constexpr std::array unit_names{"from", "second", "moments", "more", "response", "matrices"};

/// One kernel, and where its uniforms are.
struct ElasticProgram {
  ElasticProgram(const Api& api, const ElasticKernel& kernel)
      : program(api, {{GL_VERTEX_SHADER, std::string(sources::quad_vertex)},
                      {GL_FRAGMENT_SHADER, elastic_fragment_text(kernel)}}),
        extent(program.uniform("extent")), numbers(program.uniform("numbers")) {
    program.use();
    for (std::size_t unit = 0; unit < unit_names.size(); ++unit) {
      api.Uniform1i(program.uniform(unit_names[unit]), static_cast<GLint>(unit));
    }
  }

  Program program;
  GLint extent;
  GLint numbers;
};

/// The textures of a level.
struct LevelTextures {
  /// `slots`: how many.
  LevelTextures(const Api& api, const ElasticTexels& texels, Extent padded, int slots)
      : moments(api, padded, texels.moments.data()), more(api, padded, texels.more.data()),
        response(api, padded, texels.response.data()) {
    const std::vector<GLfloat> zeros(4 * padded.sites());
    for (int i = 0; i < slots; ++i) {
      fields.emplace_back(api, padded, zeros.data()).make_drawable();
    }
  }

  Target moments;
  Target more;
  Target response;
  std::vector<Target> fields; ///< by slot
};

class ElasticFragment {
public:
  static constexpr int block = 2;
  static constexpr bool has_volumes = false;

  explicit ElasticFragment(const Context& context) : gl_(context.api()), quad_(gl_) {}

  static std::int64_t coarse_size() { return 0; }

  void load(const ElasticHierarchy& hierarchy, const ElasticLayout& layout) {
    const std::vector<float> table = elastic_matrices(hierarchy);
    constexpr int table_width = elastic_matrices_across * elastic_matrix_texels;
    const Extent table_extent{table_width, static_cast<int>(table.size() / 4 / table_width)};
    require_fits(layout.levels.front().sites, table_extent);
    layout_ = layout;
    levels_.clear();
    sums_.clear();
    std::size_t matrices_before = 0;
    for (const ElasticLevel& level : hierarchy.levels) {
      const Extent padded = ElasticLayout::padded(level.grid.sites);
      ElasticTexels texels(padded.sites());
      texels.matrices = matrices_before;
      texels.add(level, ElasticLayout::alone(level.grid.sites));
      matrices_before = texels.matrices;
      levels_.emplace_back(gl_, texels, padded, levels_.empty() ? elastic_slots : elastic_slots_on_levels);
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
    for (int y = 0; y < values.extent.height; ++y) {
      auto at = static_cast<std::size_t>(4 * (part.first + y * part.pitch));
      for (std::size_t i = values.extent.index(0, y); i < values.extent.index(0, y + 1); ++i, at += 4) {
        pixels_[at] = values[0][i];
        pixels_[at + 1] = values[1][i];
      }
    }
    texture(to).upload(pixels_.data());
  }

  void read(ElasticArray array, VectorField& values) {
    pixels_.resize(4 * values.extent.sites());
    texture(array).draw_into();
    gl_.ReadPixels(1, 1, values.extent.width, values.extent.height, GL_RGBA, GL_FLOAT, pixels_.data());
    for (std::size_t i = 0; i < values[0].size(); ++i) {
      values[0][i] = pixels_[4 * i];
      values[1][i] = pixels_[4 * i + 1];
    }
  }

  [[nodiscard]] float read_sum(ElasticArray array) {
    std::array<GLfloat, 4> pixel{};
    texture(array).draw_into();
    gl_.ReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, pixel.data());
    return pixel.front();
  }

  void run(std::span<const ElasticWork> work) {
    for (const ElasticWork& piece : work) {
      run(std::get<ElasticCall>(piece));
    }
  }

private:
  void run(const ElasticCall& call) {
    const ElasticProgram& kernel = compiled(call.kernel);
    const ElasticParameters& p = call.parameters;
    kernel.program.use();
    if (kernel.extent >= 0) {
      gl_.Uniform2f(kernel.extent, static_cast<GLfloat>(p.from.width), static_cast<GLfloat>(p.from.height));
    }
    if (kernel.numbers >= 0) {
      gl_.Uniform4f(kernel.numbers, p.nu, p.shear, p.factor, 0.0F);
    }
    const LevelTextures& constants = levels_.at(static_cast<std::size_t>(call.from.level));
    texture(call.from).bind(from);
    texture(call.second).bind(second);
    constants.moments.bind(moments);
    constants.more.bind(more);
    constants.response.bind(response);
    (call.kernel.step == ElasticStep::solve ? *inverse_ : *matrices_).bind(matrices);
    texture(call.to).draw_into();
    const GLint margin = call.to.slot < elastic_slots ? 1 : 0;
    quad_.draw({margin, margin}, {p.to.width, p.to.height});
  }

  [[nodiscard]] Target& texture(ElasticArray array) {
    return array.slot < elastic_slots ? levels_.at(static_cast<std::size_t>(array.level))
                                            .fields.at(static_cast<std::size_t>(array.slot))
                                      : sums_.at(static_cast<std::size_t>(array.slot - elastic_sums));
  }

  void require_fits(Extent sites, Extent table) const {
    GLint limit = 0;
    gl_.GetIntegerv(GL_MAX_RECTANGLE_TEXTURE_SIZE_ARB, &limit);
    const Extent padded = ElasticLayout::padded(sites);
    if (std::max({padded.width, padded.height, table.width, table.height}) > limit) {
      throw TooLarge(fmt::format("{} x {} sites need textures of {} x {} for the elastic energy, and one of "
                                 "{} x {} for cells beside conditions; this device's rectangle textures end "
                                 "at {} x {}",
                                 sites.width, sites.height, padded.width, padded.height, table.width,
                                 table.height, limit, limit));
    }
  }

  void load_inverse(const ElasticHierarchy& hierarchy) {
    const auto sites = static_cast<int>(hierarchy.levels.back().grid.sites.sites());
    std::vector<GLfloat> texels(2 * hierarchy.coarsest_inverse.size());
    for (std::size_t i = 0; i < hierarchy.coarsest_inverse.size(); i += 2) {
      texels[2 * i] = hierarchy.coarsest_inverse[i];
      texels[2 * i + 1] = hierarchy.coarsest_inverse[i + 1];
    }
    inverse_.emplace(gl_, Extent{sites, 2 * sites}, texels.data());
  }

  const ElasticProgram& compiled(const ElasticKernel& kernel) {
    auto found = programs_.find(kernel);
    if (found == programs_.end()) {
      found = programs_.try_emplace(kernel, gl_, kernel).first;
    }
    return found->second;
  }

  const Api& gl_;
  Quad quad_;
  ElasticLayout layout_;
  std::vector<LevelTextures> levels_;
  std::vector<Target> sums_;
  std::optional<Target> matrices_; ///< elastic_matrices()
  std::optional<Target> inverse_;
  std::map<ElasticKernel, ElasticProgram> programs_;
  std::vector<GLfloat> pixels_; ///< RGBA staging
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_fragment(std::string name, std::unique_ptr<Context> context) {
  return std::make_unique<ElasticLevelSession<Context, ElasticFragment>>(std::move(name), std::move(context));
}

std::string elastic_fragment_text(const ElasticKernel& kernel) {
  return assemble(sources::elastic_fragment,
                  fmt::format("#define STEP {:d}\n#define HAS_LOAD {:d}\n#define IS_IMAGE {:d}\n"
                              "#define HAS_MASKED {:d}\n",
                              static_cast<int>(kernel.step), kernel.has_load, kernel.is_image,
                              kernel.has_masked));
}

} // namespace hdmbench::gl
