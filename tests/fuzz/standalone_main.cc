// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target without libFuzzer: its seeds, the files it is given, and mutations of both.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/mutator.h"

namespace waymark::fuzz {
namespace {

// What to leave behind when the target ends the process.
const Bytes* g_current = nullptr;
const char* g_target = "";

void LeaveInput(int signal) {
  const std::string path = fmt::format("crash-{}", g_target);
  if (std::FILE* file = std::fopen(path.c_str(), "wb"); file != nullptr && g_current != nullptr) {
    std::fwrite(g_current->data(), 1, g_current->size(), file);
    std::fclose(file);
    std::fprintf(stderr, "the input is in %s\n", path.c_str());
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void Try(const Bytes& bytes) {
  g_current = &bytes;
  TryOne(bytes);
}

Bytes ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteSeeds(const std::filesystem::path& folder, const std::vector<Bytes>& seeds) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    std::ofstream(folder / fmt::format("seed_{}", i), std::ios::binary)
        .write(reinterpret_cast<const char*>(seeds[i].data()),
               static_cast<std::streamsize>(seeds[i].size()));
  }
}

int Run(int argc, char** argv) {
  CLI::App app("Tries one decoder on its seeds, on kept inputs and on mutations of them.");
  std::size_t iterations = 20000;
  std::uint64_t seed = 1;
  std::string corpus, write_seeds;
  app.add_option("--iterations", iterations, "mutated inputs to try")->capture_default_str();
  app.add_option("--seed", seed, "of the mutations")->capture_default_str();
  app.add_option("--corpus", corpus, "folder of kept inputs; it need not exist");
  app.add_option("--write-seeds", write_seeds, "write the seeds into this folder and end");
  CLI11_PARSE(app, argc, argv);

  std::vector<Bytes> inputs = Seeds();
  if (!write_seeds.empty()) {
    WriteSeeds(write_seeds, inputs);
    return 0;
  }
  const std::string name = std::filesystem::path(argv[0]).filename().string();
  g_target = name.c_str();
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL}) {
    std::signal(signal, LeaveInput);
  }
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(corpus, ignored)) {
    inputs.push_back(ReadAll(entry.path()));
  }
  for (const Bytes& input : inputs) Try(input);
  Mutator mutator(seed);
  for (std::size_t i = 0; i < iterations; ++i) {
    const Bytes& other = inputs[(i / inputs.size()) % inputs.size()];
    Try(mutator.Mutate(inputs[i % inputs.size()], other));
  }
  fmt::print("{}: {} inputs and {} mutations\n", name, inputs.size(), iterations);
  return 0;
}

}  // namespace
}  // namespace waymark::fuzz

int main(int argc, char** argv) { return waymark::fuzz::Run(argc, argv); }
