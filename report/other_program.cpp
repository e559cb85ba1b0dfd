// SPDX-License-Identifier: Apache-2.0
#include "report/other_program.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include <QProcess>
#include <QProcessEnvironment>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

namespace gyrotherm::report {
namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 5> kPackages{{{"xmlsec1", "xmlsec1"},
                                                                             {"pdfsig", "poppler-utils"},
                                                                             {"certutil", "libnss3-tools"},
                                                                             {"pk12util", "libnss3-tools"},
                                                                             {"openssl", "openssl"}}};

std::string package_for(const std::string& program) {
  for (const auto& [name, package] : kPackages)
    if (name == program) return package;
  return program;
}

tl::unexpected<Fault> not_started_fault(const std::string& program) {
  return failure(FaultKind::bad_file, program,
                 fmt::format("is not installed or cannot be run; it is in the Debian package {}: "
                             "sudo apt install {}",
                             package_for(program), package_for(program)));
}

}  // namespace

Result<ProgramRun> run_program(const std::string& program, const std::vector<std::string>& arguments,
                               std::chrono::milliseconds longest) {
  QProcess process;
  QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
  environment.insert("LC_ALL", "C.UTF-8");
  environment.insert("TZ", "UTC");
  process.setProcessEnvironment(environment);
  process.setProcessChannelMode(QProcess::MergedChannels);
  process.setStandardInputFile(QProcess::nullDevice());
  QStringList qt_arguments;
  for (const std::string& argument : arguments) qt_arguments << QString::fromStdString(argument);
  process.start(QString::fromStdString(program), qt_arguments, QIODevice::ReadOnly);
  const int milliseconds = static_cast<int>(longest.count());
  if (!process.waitForStarted(milliseconds)) return not_started_fault(program);
  if (!process.waitForFinished(milliseconds)) {
    process.kill();
    process.waitForFinished(milliseconds);
    return failure(FaultKind::timeout, program, fmt::format("did not exit within {} ms", milliseconds));
  }
  if (process.exitStatus() != QProcess::NormalExit)
    return failure(FaultKind::refused, program, "was terminated by a signal");
  return ProgramRun{process.exitCode(), process.readAll().toStdString()};
}

Result<PrivateFolder> PrivateFolder::make() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code error;
  const bool usable = runtime != nullptr && std::filesystem::is_directory(runtime, error);
  std::string path =
      (usable ? std::string(runtime) : std::filesystem::temp_directory_path(error).string()) + "/gyrotherm-sign-XXXXXX";
  if (::mkdtemp(path.data()) == nullptr)
    return failure(FaultKind::storage, path, std::generic_category().message(errno));
  return PrivateFolder(std::move(path));
}

PrivateFolder::~PrivateFolder() {
  std::error_code error;
  if (!path_.empty()) std::filesystem::remove_all(path_, error);
}

}  // namespace gyrotherm::report
