// The machine code that compilers for GPUs make of every kernel, without a GPU: no operation is fused where a
// text forbids it, that one is would be seen, and what hot kernels cost is as committed.

#include "backends/shared/subprocess.hpp"
#include "harness/check/machine_code/operations.hpp"
#include "harness/check/machine_code/programs.hpp"
#include "harness/scene/files.hpp"
#include "test/program.hpp"

namespace hdmbench::test {
namespace {

using nlohmann::json;

/// A line of assembly, and what it counts as.
struct Line {
  InstructionSet set;
  const char* text;
  int instructions, multiplies, adds;
  std::size_t fused;
};

TEST(MachineCode, TellsWhatRoundsOnceFromWhatRoundsTwice) {
  using enum InstructionSet;
  for (const Line& line : {
           Line{amd, "\tv_mul_f32_e32 v1, v2, v3          ; 10020702", 1, 1, 0, 0},
           Line{amd, "\tv_subrev_f32_e32 v1, v2, v3", 1, 0, 1, 0},
           Line{amd, "\tv_fmac_f32_e32 v1, v2, v3", 1, 0, 0, 1},
           Line{amd, "\tv_fma_f32 v1, v2, v3, -v4", 1, 0, 0, 1},
           Line{amd, "\tv_fmamk_f32 v1, v2, 0x3e000000, v4", 1, 0, 0, 1},
           Line{amd, "\tv_pk_fma_f32 v[0:1], v[2:3], v[4:5], v[6:7]", 1, 0, 0, 1},
           Line{amd, "\tv_mac_f32_e32 v1, v2, v3", 1, 1, 1, 0}, // GCN's rounds the product, too
           Line{amd, "\tv_dual_mul_f32 v1, v2, v3 :: v_dual_fmac_f32 v4, v5, v6", 1, 1, 0, 1},
           Line{amd, "\tv_mul_lo_u32 v1, v2, v3", 1, 0, 0, 0},
           Line{amd, "\tglobal_load_dword v1, v2, s[0:1]", 1, 0, 0, 0},
           Line{amd, "BB0_1:", 0, 0, 0, 0},
           Line{amd, "; %bb.0:", 0, 0, 0, 0},
           Line{ptx, "\tmul.rn.f32 \t%f1, %f2, %f3;", 1, 1, 0, 0},
           Line{ptx, "\tsub.rn.ftz.f32 \t%f1, %f2, %f3;", 1, 0, 1, 0},
           Line{ptx, "\t@%p1 fma.rn.f32 \t%f1, %f2, %f3, %f4;", 1, 0, 0, 1},
           Line{ptx, "\tmul.f32 \t%f1, %f2, %f3;", 1, 0, 0, 1}, // which ptxas may fuse
           Line{ptx, "\tmad.lo.s32 \t%r1, %r2, %r3, %r4;", 1, 0, 0, 0},
           Line{ptx, "\t.reg .f32 \t%f<9>;", 0, 0, 0, 0},
           Line{sass, "        /*0070*/              @!P0 FFMA R1, R2, R3, R4 ;  /* 0x000 */", 1, 0, 0, 1},
           Line{sass, "        /*0080*/                   FADD.FTZ R1, R2, R3 ;", 1, 0, 1, 0},
           Line{sass, "        /*0090*/                   FMUL R1, R2, 8 ;", 1, 1, 0, 0},
           Line{sass, "                                               /* 0x000fe20000000f00 */", 0, 0, 0, 0},
           Line{intel, "        mad (8|M0)  r1.0<1>:f  r2.0<8;1>:f  r3.0<8;1>:f  r4.0<1>:f", 1, 0, 0, 1},
           Line{intel, "(W&f1.1) mul (8|M0)  r1.0<1>:f  r2.0<8;8,1>:f  r3.0<8;8,1>:f", 1, 1, 0, 0},
           Line{intel, "        mad (8|M0)  r1.0<1>:d  r2.0<8;1>:d  r3.0<8;1>:d  r4.0<1>:d", 1, 0, 0, 0},
           Line{intel, "//.kernel elastic_step", 0, 0, 0, 0},
       }) {
    SCOPED_TRACE(line.text);
    const Operations found = count_operations(line.set, line.text);
    EXPECT_EQ(found.instructions, line.instructions);
    EXPECT_EQ(found.multiplies, line.multiplies);
    EXPECT_EQ(found.adds, line.adds);
    EXPECT_EQ(found.fused.size(), line.fused);
  }
}

TEST(MachineCode, NamesTheLineOfTheTextThatWasFused) {
  const Operations found =
      count_operations(InstructionSet::amd, "\t.loc 1 2 9 ; text.cl:2:9\n\tv_fmac_f32_e32 v1, v2, v3\n",
                       "first\n  a = a + b * c;\n");
  EXPECT_THAT(found.fused, ElementsAre("line 2: a = a + b * c; (v_fmac_f32_e32)"));
}

TEST(MachineCode, AsksForTheProgramsOfEveryTextDimensionStepAndRule) {
  for (const GpuTexts texts : {GpuTexts::opencl, GpuTexts::vulkan}) {
    std::set<std::string> names;
    for (const GpuProgram& program : gpu_programs(texts)) {
      const std::string name = fmt::format("{} {} {} axes", program.text, program.kernel, program.kind.axes);
      EXPECT_TRUE(names.insert(name).second) << "two programs have the name " << name;
    }
    const bool is_opencl = texts == GpuTexts::opencl;
    const std::string ending = is_opencl ? "cl" : "comp";
    std::vector<std::string> needed;
    for (const int axes : {2, 3}) {
      for (const char* const step :
           {"relax", "relax load", "relax load beside masked cells", "relax from zero", "residual image",
            "residual load", "restrict", "restrict image", "interpolate", "correct image", "advance",
            "products", "squares"}) {
        const bool volume_has_image = axes == 3 && std::string_view(step) == "relax";
        needed.push_back(
            fmt::format("elastic.{} {}{} {} axes", ending, step, volume_has_image ? " image" : "", axes));
      }
      for (const char* const pass : {"sample", "project", "count"}) {
        needed.push_back(fmt::format("levels.{} {} {} axes", ending, pass, axes));
      }
      for (const char* const rule :
           {is_opencl && axes == 2 ? "steps 5 candidates 1 colours class 0 active"
            : is_opencl            ? "steps 5 candidates 1 colours class 0"
                                   : "steps 5 candidates 1 colours class 7",
            "closed form 1 candidates 1 colours class 7", "annealing 4 candidates 2 colours class 7",
            "closed form 1 candidates 2 colours class 7"}) {
        needed.push_back(fmt::format("sweep.{} {} {} axes", ending, rule, axes));
      }
    }
    if (!is_opencl) {
      needed.insert(needed.end(),
                    {"coarse_levels.comp 5 candidates 2 axes", "elastic.comp coarsest levels 2 axes",
                     "elastic.comp coarsest levels 3 axes"});
    }
    EXPECT_THAT(names, testing::IsSupersetOf(needed));
  }
}

/// One small kernel of each text.
const std::string small_kernels =
    "--kernels 'project 2 axes,advance 3 axes,until rest,closed form 1 candidates 1 colours class 7 2 axes'";

/// Says which targets were not compiled for.
void name_missing(const json& rows) {
  for (const json& row : rows) {
    if (row["verdict"] == "not there") {
      fmt::print("{}: not compiled for: {}\n", row["target"].get<std::string>(),
                 row["reason"].get<std::string>());
    }
  }
}

TEST(MachineCode, WithoutTheWordThatForbidsItEveryTextIsFusedOnEveryTarget) {
  const Outcome outcome = hdmbench("machine-code --planted " + small_kernels);
  if (outcome.output.find("no compiler for GPUs is there") != std::string::npos) {
    GTEST_SKIP() << outcome.output;
  }
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.output,
              HasSubstr("fused operations are found in every text, on every target that has them"))
      << outcome.output;
  // What has no sum of products cannot be fused, so that nothing is found there.
  expect_run(1, "machine-code --planted --kernels 'count'", HasSubstr("NOTHING IS FOUND in "));
}

TEST(MachineCode, NamesACompilerThatIsNotThere) {
  const std::string nothing = "PATH=/none VK_DRIVER_FILES=/none VK_ICD_FILENAMES=/none ";
  expect_run(2, "machine-code --kernels project", HasSubstr("no compiler for GPUs is there"), nothing);
  expect_run(2, "machine-code --targets gfx900", HasSubstr("(Debian: clang)"), nothing);
  expect_run(2, "machine-code --targets gfx901", HasSubstr("the targets are vega10, "));
  expect_run(2, "machine-code --kernels nothing", HasSubstr("no kernel's name has \"nothing\" in it"));
}

/// A compiler of which is said what it does.
std::string with_compiler(const TemporaryDirectory& folder, const char* name, const std::string& script) {
  const auto file = folder.path() / name;
  std::ofstream(file) << "#!/bin/sh\n" << script << '\n';
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return fmt::format("PATH={}:$PATH", folder.path().string());
}

std::string with_clang(const TemporaryDirectory& folder, const std::string& script) {
  return with_compiler(folder, "clang",
                       "case \"$1\" in --version) echo version 99.0.1; exit;; esac\n" + script);
}

TEST(MachineCode, ACompilerThatRefusesOrFusesIsNoPass) {
  const TemporaryDirectory folder;
  const auto file = folder.path() / "rows";
  const std::string words = fmt::format(
      "machine-code --targets gfx900 --kernels advance --json {0}.json --junit {0}.xml", file.string());
  expect_run(1, words, HasSubstr("it is too late"), with_clang(folder, "echo it is too late >&2; exit 3"));
  EXPECT_EQ(read_json(file.string() + ".json")["results"][0]["verdict"], "refused");
  expect_run(1, words, HasSubstr("v_fmac_f32 v1, v2, v3"),
             with_clang(folder, "for last; do :; done; printf '\\tv_fmac_f32 v1, v2, v3\\n' > $last"));
  const json row = read_json(file.string() + ".json")["results"][0];
  EXPECT_EQ(row["verdict"], "fused");
  EXPECT_EQ(row["fused"], 1);
  EXPECT_EQ(row["compiler"], "clang 99.0.1");
  EXPECT_THAT(file_text(file.string() + ".xml"),
              AllOf(HasSubstr("failures=\"2\" skipped=\"0\""), HasSubstr("v_fmac_f32")));
}

/// Intel's compiler gives widths up that spill, and tries again where all do: what it did last counts,
/// whatever order a file system has its files in.
TEST(MachineCode, TheLastAttemptCounts) {
  for (const auto& [names, instructions] : {std::pair{"a_simd8_e a_simd16_e", 2},
                                            {"a_1_simd8_e a_simd16_e a_simd8_e", 1},
                                            {"a_simd8_e a_1_simd8_e a_1_simd16_e", 3}}) {
    const TemporaryDirectory folder;
    const auto file = folder.path() / "rows.json";
    const std::string multiply = R"(mul (8|M0)  r1.0<1>:f  r2.0<8;8,1>:f  r3.0<8;8,1>:f)";
    expect_run(
        0, fmt::format("machine-code --targets skl --kernels advance --json {}", file.string()),
        HasSubstr("No fused operation"),
        with_compiler(folder, "ocloc",
                      fmt::format("[ $1 = compile ] || {{ [ $2 = --help ] || echo 99.0.1 > $2; exit 0; }}\n"
                                  "while [ \"$1\" != -out_dir ]; do shift; done; n=1\n"
                                  "for name in {}; do for i in $(seq $n); do echo '{}'; done > "
                                  "$2/$name.asm; n=$((n + 1)); done",
                                  names, multiply)));
    EXPECT_EQ(read_json(file)["results"][0]["instructions"], instructions) << names;
  }
}

/// The figures in which rows of the same program by the same compiler differ by more than 2 %: instructions,
/// registers, local memory. `compared`: how many rows had a counterpart.
std::vector<std::string> changes(const json& committed, const json& now, int& compared) {
  std::map<std::string, json> before;
  const auto name = [](const json& row) {
    return fmt::format("{} {} {} axes for {} by {}", row["text"].get<std::string>(),
                       row["kernel"].get<std::string>(), row["axes"].get<int>(),
                       row["target"].get<std::string>(), row["compiler"].get<std::string>());
  };
  for (const json& row : committed) {
    before[name(row)] = row;
  }
  std::vector<std::string> found;
  for (const json& row : now) {
    const auto other = before.find(name(row));
    if (other == before.end()) {
      continue;
    }
    ++compared;
    for (const char* const key : {"instructions", "registers", "local_bytes"}) {
      constexpr double tolerance = 0.02;
      const json& was = other->second[key];
      const bool same =
          was.is_null() || row[key].is_null()
              ? was == row[key]
              : std::abs(row[key].get<double>() - was.get<double>()) <= tolerance * was.get<double>();
      if (!same) {
        found.push_back(fmt::format("{}: {} {}, committed {}", name(row), key, row[key].dump(), was.dump()));
      }
    }
  }
  return found;
}

TEST(MachineCode, WhatIsAddressedAtRunTimeIsNoArrayInLocalMemory) {
  const TemporaryDirectory folder;
  const auto file = folder.path() / "rows.json";
  const Outcome outcome = hdmbench(
      "machine-code --targets sm_80 --kernels 'coarsest levels 2 axes,annealing' --json " + file.string());
  if (outcome.status == 2) {
    GTEST_SKIP() << outcome.output;
  }
  for (const json& row : read_json(file)["results"]) {
    EXPECT_EQ(row["local_bytes"], 0) << row.dump();
  }
}

TEST(MachineCode, HotKernelsFuseNothingAndCostWhatIsCommitted) {
  const auto committed = std::filesystem::path(HDMBENCH_SOURCE) / "test/machine_code.json";
  const json before = read_json(committed);
  const TemporaryDirectory folder;
  const auto file = folder.path() / "now.json";
  const std::string words = before["context"]["arguments"];
  const Outcome outcome = hdmbench(words.substr(0, words.find(" --json")) + " --json " + file.string());
  if (outcome.output.find("no compiler for GPUs is there") != std::string::npos) {
    GTEST_SKIP() << outcome.output;
  }
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  json now = read_json(file)["results"];
  name_missing(now);
  for (const json& row : now) { // PTX has registers without end: what is local there is an array
    EXPECT_TRUE(!row["target"].get<std::string>().starts_with("sm_") || row["local_bytes"] == 0)
        << row.dump();
  }
  int compared = 0;
  EXPECT_THAT(changes(before["results"], now, compared), IsEmpty())
      << "If that is meant: hdmbench " << words.substr(0, words.find(" --json")) << " --json " << committed;
  if (compared == 0) {
    GTEST_SKIP() << "the committed figures are of other compilers";
  }
  now = before["results"];
  for (json& row : now) {
    row["registers"] = row["registers"].is_null() ? json() : json(row["registers"].get<int>() + 8);
    row["instructions"] = row["instructions"].get<int>() * 103 / 100;
  }
  EXPECT_GE(changes(before["results"], now, compared).size(), now.size()) << "what costs more is not seen";
}

} // namespace
} // namespace hdmbench::test
