#include "harness/check/machine_code/machine_code.hpp"

#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace hdmbench {

namespace {

using nlohmann::json;

std::vector<GpuTarget> chosen_targets(const std::vector<std::string>& names) {
  const std::span<const GpuTarget> all = gpu_targets();
  std::vector<GpuTarget> chosen;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name, &GpuTarget::name);
    if (found == all.end()) {
      std::vector<std::string_view> known;
      std::ranges::transform(all, std::back_inserter(known), &GpuTarget::name);
      throw InputError(
          fmt::format("there is no target \"{}\"; the targets are {}", name, fmt::join(known, ", ")));
    }
    chosen.push_back(*found);
  }
  return names.empty() ? std::vector<GpuTarget>(all.begin(), all.end()) : chosen;
}

std::vector<GpuProgram> chosen_programs(GpuTexts texts, const std::vector<std::string>& words) {
  std::vector<GpuProgram> programs = gpu_programs(texts);
  std::erase_if(programs, [&](const GpuProgram& program) {
    const std::string name = fmt::format("{} {} {} axes", program.text, program.kernel, program.kind.axes);
    return !words.empty() && std::ranges::none_of(words, [&](const std::string& word) {
      return name.find(word) != std::string::npos;
    });
  });
  if (programs.empty()) {
    throw InputError(fmt::format("no kernel's name has \"{}\" in it", fmt::join(words, "\" or \"")));
  }
  return programs;
}

GpuTexts texts_of(const GpuTarget& target) {
  return target.compiler == GpuCompiler::radv ? GpuTexts::vulkan : GpuTexts::opencl;
}

json row_of(const GpuTarget& target, const GpuProgram& program, const std::string& compiler) {
  return {{"kernel", program.kernel},
          {"text", program.text},
          {"axes", program.kind.axes},
          {"target", target.name},
          {"gpu", target.gpu},
          {"compiler", compiler},
          {"multiplies", nullptr},
          {"adds", nullptr},
          {"fused", nullptr},
          {"fused_lines", json::array()},
          {"instructions", nullptr},
          {"registers", nullptr},
          {"registers_of", target.registers > 0 ? json(target.registers) : json()},
          {"spills", nullptr},
          {"local_bytes", nullptr},
          {"verdict", "refused"},
          {"reason", ""}};
}

void judge(json& row, const json& found) {
  row.update(found);
  json& lines = row["fused_lines"];
  constexpr std::size_t most = 5; // of them say where
  if (lines.size() > most) {
    lines.erase(lines.begin() + most, lines.end());
  }
  row["verdict"] = row["fused"] == 0 ? "no fused operation" : "fused";
}

/// Does `jobs` by as many threads as there are processors; each is a process that is waited for.
void do_all(const std::vector<std::function<void()>>& jobs, Progress& progress) {
  std::atomic<std::size_t> next = 0;
  std::mutex lock;
  const auto work = [&] {
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
      jobs[i]();
      const std::scoped_lock guard(lock);
      progress.advance(1.0);
    }
  };
  std::vector<std::jthread> threads;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back(work);
  }
}

} // namespace

json machine_code(const MachineCodeOptions& options, Progress& progress) {
  std::map<GpuTexts, std::vector<GpuProgram>> programs;
  std::map<GpuCompiler, std::string> compilers; // with their versions
  std::vector<json> rows;                       // by job, so that their order is none of the threads'
  std::vector<std::function<void()>> jobs;
  const std::vector<GpuTarget> targets = chosen_targets(options.targets);
  const auto add_job = [&](std::size_t first, std::size_t count, const auto& compile) {
    jobs.emplace_back([&rows, first, count, compile] {
      json found;
      std::string reason;
      try {
        found = compile();
      } catch (const std::exception& error) {
        reason = error.what();
      }
      for (std::size_t i = 0; i < count; ++i) {
        reason.empty() ? judge(rows[first + i], found.at(i)) : void(rows[first + i]["reason"] = reason);
      }
    });
  };
  for (const GpuTarget& target : targets) {
    try {
      compilers.try_emplace(target.compiler, compiler_of(target.compiler));
    } catch (const DeviceError& error) {
      json row = row_of(target, {.kind = {}, .kernel = "all", .text = ""}, "");
      row.update({{"verdict", "not there"}, {"reason", error.what()}});
      rows.push_back(std::move(row));
      continue;
    }
    std::vector<GpuProgram>& own = programs[texts_of(target)];
    if (own.empty()) {
      progress.describe("which programs a GPU is asked to compile");
      own = chosen_programs(texts_of(target), options.kernels);
    }
    const std::size_t first = rows.size();
    for (const GpuProgram& program : own) {
      rows.push_back(row_of(target, program, compilers[target.compiler]));
    }
    if (target.compiler == GpuCompiler::radv) {
      add_job(first, own.size(), [&] { return compile_by_radv_apart(target, own, options.word); });
    } else {
      for (std::size_t i = 0; i < own.size(); ++i) {
        add_job(first + i, 1, [&, i] {
          const TemporaryDirectory folder;
          return json::array({compile_file(target, own[i], options.word, folder.path())});
        });
      }
    }
  }
  progress.describe(fmt::format("{} programs for {} targets", rows.size(), targets.size()));
  progress.set_total(static_cast<double>(jobs.size()));
  do_all(jobs, progress);
  return rows;
}

} // namespace hdmbench
