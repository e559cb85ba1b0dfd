#include "app/sha256.hpp"

#include <QCryptographicHash>

namespace gyrotherm {

std::string sha256(std::string_view text) {
  const auto view = QByteArrayView(text.data(), static_cast<qsizetype>(text.size()));
  return QCryptographicHash::hash(view, QCryptographicHash::Sha256).toHex().toStdString();
}

}  // namespace gyrotherm
