#include "harness/check/machine_code/compilers.hpp"

#include "backends/shared/subprocess.hpp"
#include "harness/check/machine_code/operations.hpp"
#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#ifdef HDMBENCH_WITH_OPENCL
#include "backends/opencl/program_text.hpp"
#endif

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <regex>
#include <sstream>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

using nlohmann::json;
using Path = std::filesystem::path;
using Words = std::vector<std::string>;

constexpr std::array all_targets{// RADV makes multiply-adds that round twice for GCN.
                                 GpuTarget{"vega10", "AMD GCN 5", GpuCompiler::radv, 256, false},
                                 GpuTarget{"navi21", "AMD RDNA 2", GpuCompiler::radv, 256},
                                 GpuTarget{"vangogh", "AMD RDNA 2, APU", GpuCompiler::radv, 256},
                                 GpuTarget{"gfx1100", "AMD RDNA 3", GpuCompiler::radv, 256},
                                 GpuTarget{"gfx900", "AMD GCN 5", GpuCompiler::clang_amd, 256},
                                 GpuTarget{"gfx1030", "AMD RDNA 2", GpuCompiler::clang_amd, 256},
                                 GpuTarget{"sm_70", "NVIDIA Volta", GpuCompiler::clang_nvidia, 255},
                                 GpuTarget{"sm_80", "NVIDIA Ampere", GpuCompiler::clang_nvidia, 255},
                                 GpuTarget{"skl", "Intel Gen 9", GpuCompiler::ocloc, 0},
                                 GpuTarget{"tgllp", "Intel Gen 12", GpuCompiler::ocloc, 0}};

/// What a driver's library has of OpenCL C, and clang alone does not.
constexpr std::string_view library_of_clang = R"(
#ifdef __AMDGCN__
#define get_local_id(d) ((size_t)__builtin_amdgcn_workitem_id_x())
#define get_group_id(d) ((size_t)__builtin_amdgcn_workgroup_id_x())
#define get_local_size(d) ((size_t)__builtin_amdgcn_workgroup_size_x())
#define get_global_size(d) ((size_t)__builtin_amdgcn_grid_size_x())
#define get_num_groups(d) (get_global_size(0) / get_local_size(0))
#define barrier(fence) __builtin_amdgcn_s_barrier()
#else
#define get_local_id(d) ((size_t)__nvvm_read_ptx_sreg_tid_x())
#define get_group_id(d) ((size_t)__nvvm_read_ptx_sreg_ctaid_x())
#define get_local_size(d) ((size_t)__nvvm_read_ptx_sreg_ntid_x())
#define get_num_groups(d) ((size_t)__nvvm_read_ptx_sreg_nctaid_x())
#define get_global_size(d) (get_num_groups(0) * get_local_size(0))
#define barrier(fence) __syncthreads()
#endif
#define get_global_id(d) (get_group_id(0) * get_local_size(0) + get_local_id(0))
#define atomic_add(to, value) __sync_fetch_and_add(to, value)
#define fabs(a) __builtin_fabsf(a)
#define floor(a) __builtin_floorf(a)
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
)";

struct Ran {
  std::string output;
  std::string errors;
};

/// Throws DeviceError with the program's words unless it ends well.
Ran run(const Words& words, const Path& folder, const ProcessOptions& options = {}) {
  const Path output = folder / "output.txt";
  const Path errors = folder / "errors.txt";
  ProcessEnd end;
  try {
    end = run_process(words, output, errors, options);
  } catch (const InputError& error) {
    throw DeviceError(error.what());
  }
  const Ran ran{file_text(output), file_text(errors)};
  if (!end.good()) {
    throw DeviceError(
        fmt::format("{} {}: {}{}", words.front(), end.sentence(options), ran.errors, ran.output));
  }
  return ran;
}

/// The first whole number after `mark`; none where the text has no such mark.
std::optional<int> number_after(std::string_view text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  text.remove_prefix(std::min(text.find_first_of("0123456789", at + mark.size()), text.size()));
  int number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

json fields_of(const Operations& found) {
  return {{"multiplies", found.multiplies},
          {"adds", found.adds},
          {"fused", found.fused.size()},
          {"fused_lines", found.fused},
          {"instructions", found.instructions}};
}

void add(json& row, const char* key, std::optional<int> value) {
  row[key] = value ? json(*value) : json();
}

std::string text_of([[maybe_unused]] const GpuProgram& program, [[maybe_unused]] Word word) {
#ifdef HDMBENCH_WITH_OPENCL
  std::string text = opencl::program_text(program.kind).bytes;
  constexpr std::string_view forbids = "#pragma OPENCL FP_CONTRACT OFF";
  if (word == Word::taken_out) {
    text.erase(text.find(forbids), forbids.size());
  }
  return text;
#else
  throw DeviceError("this build was configured without OpenCL (-DHDMBENCH_OPENCL=ON), whose texts these are");
#endif
}

Words build_options() {
#ifdef HDMBENCH_WITH_OPENCL
  std::istringstream all{std::string(opencl::build_options)};
  return {std::istream_iterator<std::string>(all), {}};
#else
  return {};
#endif
}

/// The assembly that clang writes.
std::string by_clang(const Words& target, const Path& text, const Path& folder) {
  Words words{"clang", "-x", "cl"};
  for (const Words& more :
       {build_options(),
        Words{"-O2", "-S", "-nogpulib", "-gline-tables-only", "-fno-crash-diagnostics", "-Xclang",
              "-finclude-default-header", "-Xclang", "-fdeclare-opencl-builtins"},
        target, Words{text.string(), "-o", (folder / "assembly.s").string()}}) {
    words.insert(words.end(), more.begin(), more.end());
  }
  (void)run(words, folder);
  return file_text(folder / "assembly.s");
}

json by_clang_for_amd(const GpuTarget& target, const std::string& text, const Path& folder) {
  const std::string code = by_clang({"--target=amdgcn-amd-amdhsa", fmt::format("-mcpu={}", target.name)},
                                    folder / "text.cl", folder);
  json row = fields_of(count_operations(InstructionSet::amd, code, text));
  add(row, "registers", number_after(code, "; NumVgprs:"));
  add(row, "spills", number_after(code, ".vgpr_spill_count:"));
  add(row, "local_bytes", number_after(code, "; ScratchSize:"));
  add(row, "shared_bytes", number_after(code, "; LDSByteSize:")); // where an array may lie, too
  add(row, "occupancy", number_after(code, "; Occupancy:"));
  constexpr int keeps_denormals = 3 << 4; // of 32 bits (AMDGPU usage: FLOAT_MODE)
  row["denormals"] = (number_after(code, "; FloatMode:").value_or(0) & keeps_denormals) == keeps_denormals
                         ? "kept"
                         : "flushed";
  return row;
}

/// NVIDIA's assembler, which is in no package of Debian; empty where there is none.
std::string nvidia_tool(const char* name) {
  for (const char* const folder : {"/usr/local/cuda/bin", "/usr/bin", "/usr/local/bin"}) {
    if (const Path file = Path(folder) / name; std::filesystem::exists(file)) {
      return file.string();
    }
  }
  return {};
}

/// Adds what ptxas says, and the operations of its machine code where there is something that shows them.
void add_by_ptxas(json& row, const GpuTarget& target, const std::string& code, const Path& folder) {
  const std::string ptxas = nvidia_tool("ptxas");
  if (ptxas.empty()) {
    return;
  }
  // Without the lines of the text, which ptxas does not take in this form.
  constexpr std::string_view end = "\n}\n"; // of the kernel
  std::istringstream lines(code.substr(0, code.rfind(end, code.find("\t.section")) + end.size()));
  std::string ptx;
  for (std::string line; std::getline(lines, line);) {
    const bool is_of_lines = line.starts_with("\t.loc") || line.starts_with("\t.file");
    ptx += is_of_lines ? "" : line.substr(0, line.find(", debug")) + '\n';
  }
  const Path file = folder / "code.ptx";
  const std::string cubin = (folder / "code.cubin").string();
  write_text(file, ptx);
  Ran said;
  try {
    said = run({ptxas, "-v", fmt::format("-arch={}", target.name), "-o", cubin, file.string()}, folder);
  } catch (const DeviceError& error) {
    if (std::string_view(error.what()).find("gpu-name") == std::string_view::npos) {
      throw;
    }
    return; // newer ones have given up older GPUs
  }
  constexpr int bytes_of_register = 4;
  const std::string words = said.errors + said.output;
  add(row, "registers", number_after(words, "Used"));
  add(row, "spills", number_after(words, "bytes stack frame,").value_or(0) / bytes_of_register);
  if (const std::string shows = nvidia_tool("cuobjdump"); !shows.empty()) {
    const json sass =
        fields_of(count_operations(InstructionSet::sass, run({shows, "-sass", cubin}, folder).output));
    row["assembled_fused"] = sass["fused"];
    if (row["fused"] == 0) { // else the line of the text says more
      row.update(sass);
    }
  }
}

json by_clang_for_nvidia(const GpuTarget& target, const std::string& text, const Path& folder) {
  const std::string code = by_clang(
      {"--target=nvptx64-nvidia-cuda", "-Xclang", "-target-cpu", "-Xclang", std::string(target.name)},
      folder / "text.cl", folder);
  json row = fields_of(count_operations(InstructionSet::ptx, code, text));
  add(row, "local_bytes", number_after(code, "__local_depot0[").value_or(0));
  row["denormals"] = code.find(".ftz") == std::string::npos ? "kept" : "flushed";
  add_by_ptxas(row, target, code, folder);
  return row;
}

json by_ocloc(const GpuTarget& target, const Path& folder) {
#ifdef HDMBENCH_WITH_OPENCL
  const std::string options(opencl::build_options);
#else
  const std::string options;
#endif
  (void)run({"ocloc", "compile", "-file", (folder / "text.cl").string(), "-device", std::string(target.name),
             "-options", options, "-output", "code", "-output_no_suffix", "-out_dir", folder.string()},
            folder,
            {.environment = {{"IGC_ShaderDumpEnable", "1"}, {"IGC_DumpToCustomDir", folder.string() + "/"}}});
  // Widths that spill were given up, and where all do, the compiler has tried again: "..._1_simd8_...".
  Path last;
  std::pair<int, int> best; // attempt and width
  static const std::regex name("(?:_(\\d+))?_simd(\\d+)_.*\\.asm$");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (std::smatch found; std::regex_search(file, found, name)) {
      const std::pair attempt(found[1].matched ? std::stoi(found[1]) : 0, std::stoi(found[2]));
      if (attempt > best) {
        best = attempt;
        last = entry.path();
      }
    }
  }
  const int lanes = best.second;
  if (lanes == 0) {
    throw DeviceError("ocloc wrote no assembly (IGC_ShaderDumpEnable)");
  }
  const std::string code = file_text(last);
  constexpr int bytes_of_register = 32;
  json row = fields_of(count_operations(InstructionSet::intel, code));
  add(row, "spills", number_after(code, "//.spill size").value_or(0) / bytes_of_register);
  add(row, "local_bytes", number_after(code, "//.private memory size").value_or(0) / lanes);
  static const std::regex mode("or \\(1\\|M0\\) +cr0.*0x([0-9A-F]+):uw");
  constexpr int keeps_denormals = 1 << 7; // of 32 bits (control register 0)
  std::smatch found;
  const bool is_kept =
      std::regex_search(code, found, mode) && (std::stoi(found[1], nullptr, 16) & keeps_denormals) != 0;
  row["denormals"] = is_kept ? "kept" : "flushed";
  return row;
}

} // namespace

std::span<const GpuTarget> gpu_targets() {
  return all_targets;
}

std::string compiler_of(GpuCompiler compiler) {
  const TemporaryDirectory folder;
  const auto version = [&](const Words& words, const char* mark, const char* package) {
    try {
      const std::string said = run(words, folder.path()).output;
      static const std::regex number("[0-9]+(\\.[0-9]+)+");
      std::smatch found;
      const std::string after = said.substr(std::min(said.find(mark), said.size()));
      return std::regex_search(after, found, number) ? found.str()
                                                     : std::string("of a version that it does not say");
    } catch (const DeviceError& error) {
      throw DeviceError(fmt::format("{} (Debian: {})", error.what(), package));
    }
  };
  if (compiler == GpuCompiler::radv) {
    return compile_by_radv_apart(all_targets.front(), {}, Word::kept).back();
  }
  if (compiler == GpuCompiler::ocloc) { // it writes the answer to a file of that name
    (void)version({"ocloc", "query", "--help"}, "", "intel-opencl-icd");
    return fmt::format(
        "ocloc {}",
        version({"sh", "-c", "cd \"$0\" && ocloc query OCL_DRIVER_VERSION && cat OCL_DRIVER_VERSION",
                 folder.path().string()},
                "", "intel-opencl-icd"));
  }
  std::string name = fmt::format("clang {}", version({"clang", "--version"}, "version", "clang"));
  if (const std::string ptxas = nvidia_tool("ptxas");
      compiler == GpuCompiler::clang_nvidia && !ptxas.empty()) {
    name += fmt::format(", ptxas {}", version({ptxas, "--version"}, ", V", "none"));
  }
  return name;
}

json compile_file(const GpuTarget& target, const GpuProgram& program, Word word, const Path& folder) {
  const bool by_clang = target.compiler != GpuCompiler::ocloc;
  const std::string text =
      (by_clang ? std::string(library_of_clang) : std::string()) + text_of(program, word);
  write_text(folder / "text.cl", text);
  switch (target.compiler) {
  case GpuCompiler::clang_amd:
    return by_clang_for_amd(target, text, folder);
  case GpuCompiler::clang_nvidia:
    return by_clang_for_nvidia(target, text, folder);
  default:
    return by_ocloc(target, folder);
  }
}

} // namespace hdmbench
