// sightline-convert IN OUT MEMORY_MIB SECONDS: reads a file of another format through assimp and writes it
// as GLB, in a process that limits its own memory, time and output. `sightline convert` runs it.

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>

namespace {

constexpr std::array<std::string_view, 6> kEndings{".obj", ".ply", ".stl", ".dae", ".fbx", ".3mf"};

int complain(std::string_view text) {
  std::cerr << "sightline-convert: " << text << "\n";
  return 2;
}

/// Only functions that a signal handler may call.
void end_late(int) {
  constexpr std::string_view kText = "sightline-convert: the time is used up (--seconds)\n";
  if (::write(STDERR_FILENO, kText.data(), kText.size()) < 0) ::_exit(3);
  ::_exit(2);
}

bool limit(int what, std::uint64_t most) {
  const rlimit both{most, most};
  return ::setrlimit(static_cast<__rlimit_resource>(what), &both) == 0;
}

bool limit_process(std::uint64_t memory_mib, std::uint64_t seconds) {
  std::signal(SIGXCPU, end_late);
  std::signal(SIGALRM, end_late);
  std::signal(SIGXFSZ, SIG_IGN);
  // The hard limit of time ends what does not return from the handler.
  const rlimit time{seconds, seconds + 1};
  ::alarm(static_cast<unsigned>(2 * seconds));
  return limit(RLIMIT_AS, memory_mib << 20) && limit(RLIMIT_FSIZE, memory_mib << 20) &&
         limit(RLIMIT_CORE, 0) && ::setrlimit(RLIMIT_CPU, &time) == 0;
}

std::string ending_of(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  std::string ending = dot == std::string::npos ? "" : path.substr(dot);
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

int convert(const std::string& from, const std::string& to) {
  if (std::find(kEndings.begin(), kEndings.end(), ending_of(from)) == kEndings.end())
    return complain(from + ": the name must end with .obj, .ply, .stl, .dae, .fbx or .3mf");
  // So no input is overwritten.
  if (ending_of(to) != ".glb") return complain(to + ": the name of the output must end with .glb");
  Assimp::Importer importer;
  // Triangles alone: no lines and points. Vertices are neither joined nor moved.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      from, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure);
  if (scene == nullptr) {
    const std::string_view fault = importer.GetErrorString();
    if (fault.find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
    return complain(from + ": " + std::string(fault));
  }
  std::uint64_t triangles = 0;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) triangles += scene->mMeshes[i]->mNumFaces;
  if (triangles == 0) return complain(from + ": it has no triangles");
  // A file that is not whole never has the name.
  const std::string part = to + ".part";
  Assimp::Exporter exporter;
  if (exporter.Export(scene, "glb2", part) != aiReturn_SUCCESS) {
    std::remove(part.c_str());
    return complain(to + ": " + exporter.GetErrorString());
  }
  if (std::rename(part.c_str(), to.c_str()) != 0) {
    std::remove(part.c_str());
    return complain(to + ": " + std::strerror(errno));
  }
  std::cout << to << ": " << triangles << " triangles\n";
  return 0;
}

bool read_number(const char* text, std::uint64_t most, std::uint64_t& number) {
  const char* const end = text + std::strlen(text);
  const auto [at, error] = std::from_chars(text, end, number);
  return error == std::errc() && at == end && number > 0 && number <= most;
}

}  // namespace

int main(int count, char** arguments) {
  std::uint64_t memory_mib = 0, seconds = 0;
  if (count != 5 || !read_number(arguments[3], 1 << 20, memory_mib) ||
      !read_number(arguments[4], 86'400, seconds)) {
    return complain("usage: sightline-convert IN OUT MEMORY_MIB SECONDS");
  }
  if (!limit_process(memory_mib, seconds)) return complain("the system refuses the limits");
  try {
    return convert(arguments[1], arguments[2]);
  } catch (const std::bad_alloc&) {
    return complain("the memory is used up (--memory-mib)");
  } catch (const std::exception& error) {
    return complain(error.what());
  }
}
