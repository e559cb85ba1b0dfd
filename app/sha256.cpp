#include "app/sha256.hpp"

#include <QCryptographicHash>
#include <QFile>

namespace gyrotherm {

std::string sha256(std::string_view text) {
  const auto view = QByteArrayView(text.data(), static_cast<qsizetype>(text.size()));
  return QCryptographicHash::hash(view, QCryptographicHash::Sha256).toHex().toStdString();
}

Result<std::string> sha256_of_file(const std::string& path) {
  QFile file(QString::fromStdString(path));
  QCryptographicHash hash(QCryptographicHash::Sha256);
  if (!file.open(QIODevice::ReadOnly) || !hash.addData(&file))
    return failure(FaultKind::bad_file, path, "cannot be read: " + file.errorString().toStdString());
  return hash.result().toHex().toStdString();
}

}  // namespace gyrotherm
