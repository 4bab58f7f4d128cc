// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>

#include <memory>
#include <string>
#include <string_view>

#include "mapping/base/result.h"

/// OpenSSL's objects with owners, and its reasons as ours.
namespace waymark::session::keys::internal {

template <auto kFree>
struct Freer {
  template <typename T>
  void operator()(T* object) const {
    kFree(object);
  }
};

using BioPtr = std::unique_ptr<BIO, Freer<BIO_free_all>>;
using KeyPtr = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using KeyContextPtr = std::unique_ptr<EVP_PKEY_CTX, Freer<EVP_PKEY_CTX_free>>;
using DigestContextPtr = std::unique_ptr<EVP_MD_CTX, Freer<EVP_MD_CTX_free>>;

/// The reason that OpenSSL left for this thread; clears it.
std::string TakeReason();

/// Unavailable with `what` and OpenSSL's reason.
Error Failed(std::string_view what);

BioPtr ReadFrom(std::string_view text);
BioPtr MakeMemory();
std::string TextOf(BIO& memory);

}  // namespace waymark::session::keys::internal
