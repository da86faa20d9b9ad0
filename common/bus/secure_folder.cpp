// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/secure_folder.h"

#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

struct Free {
  void operator()(FILE* file) const { std::fclose(file); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(X509_CRL* list) const { X509_CRL_free(list); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
template <typename T>
using Owned = std::unique_ptr<T, Free>;

Owned<FILE> open_file(const std::string& path) {
  Owned<FILE> file(std::fopen(path.c_str(), "re"));
  if (!file) refuse_input(path, "cannot be read; scripts/secure.sh makes the files of --secure");
  return file;
}

Owned<X509> read_certificate(const std::string& path) {
  Owned<X509> certificate(PEM_read_X509(open_file(path).get(), nullptr, nullptr, nullptr));
  if (!certificate) refuse_input(path, "is no certificate (PEM)");
  return certificate;
}

void check_key(const std::string& path, X509* certificate) {
  struct stat info {};
  if (stat(path.c_str(), &info) == 0 && (info.st_mode & 077) != 0)
    refuse_input(path, "other users may read this key; chmod 600, or make new ones if they have");
  const Owned<EVP_PKEY> key(PEM_read_PrivateKey(open_file(path).get(), nullptr, nullptr, nullptr));
  if (!key) refuse_input(path, "is no private key (PEM)");
  if (X509_check_private_key(certificate, key.get()) != 1)
    refuse_input(path, "is not the key of the certificate beside it");
}

void check_validity(const SecureFiles& files, X509* certificate, X509* authority) {
  const std::string renew = "; a new one: scripts/secure.sh DIR --add NAME --may command";
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0)
    refuse_input(files.certificate, "this certificate is over" + renew);
  if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0)
    refuse_input(files.certificate, "this certificate is not valid yet; is the clock right?");
  if (X509_verify(certificate, X509_get0_pubkey(authority)) != 1)
    refuse_input(files.certificate, "was not signed by the authority in " + files.authority);
}

void check_revoked(const SecureFiles& files, X509* certificate) {
  if (files.revoked.empty()) return;
  const Owned<X509_CRL> list(PEM_read_X509_CRL(open_file(files.revoked).get(), nullptr, nullptr, nullptr));
  if (!list) refuse_input(files.revoked, "is no list of revoked certificates (PEM)");
  X509_REVOKED* entry = nullptr;
  if (X509_CRL_get0_by_cert(list.get(), &entry, certificate) == 1)
    refuse_input(files.certificate, "this certificate was revoked");
}

bool is_there(const std::string& path) { return access(path.c_str(), F_OK) == 0; }

std::string find_identity(const std::string& folder, bool only_looks) {
  for (const std::string& each :
       {folder, folder + (only_looks ? "/look" : "/command"), folder + (only_looks ? "/command" : "/look")}) {
    if (is_there(each + "/cert.pem")) return each;
  }
  refuse_input(folder, "has no cert.pem, command/cert.pem or look/cert.pem; scripts/secure.sh makes such a folder");
}

}  // namespace

SecureFiles find_secure_files(const std::string& folder, bool only_looks) {
  char* real = realpath(find_identity(folder, only_looks).c_str(), nullptr);  // vendors want URIs of whole paths
  SecureFiles files;
  files.folder = real ? real : folder;
  std::free(real);
  const std::string start = files.folder + "/";
  files.authority = start + "ca.pem";
  files.certificate = start + "cert.pem";
  files.key = start + "key.pem";
  files.governance = start + "governance.p7s";
  files.permissions = start + "permissions.p7s";
  if (is_there(start + "crl.pem")) files.revoked = start + "crl.pem";
  for (const std::string& each : {files.governance, files.permissions}) open_file(each);
  const auto certificate = read_certificate(files.certificate);
  const auto authority = read_certificate(files.authority);
  check_validity(files, certificate.get(), authority.get());
  check_revoked(files, certificate.get());
  check_key(files.key, certificate.get());
  return files;
}

}  // namespace hrp
