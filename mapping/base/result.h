// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <tl/expected.hpp>

#include "mapping/base/check.h"

namespace waymark {

enum class ErrorCode {
  kInvalidArgument,
  kNotFound,
  kConflict,
  kUnavailable,
  kTimeout,
  kCorrupt,
  kUnsupported,
};

/// The name of a code as users see it, for example "not found".
std::string_view ErrorCodeName(ErrorCode code);

/// A foreseeable failure. The message states which object, what was expected and what was found.
struct Error {
  ErrorCode code;
  std::string message;

  friend bool operator==(const Error&, const Error&) = default;
};

/// "corrupt: submaps/ab12: expected 4096 bytes, found 17"
std::string ToString(const Error& error);

/// Builds an Error with a formatted message: `MakeError(ErrorCode::kCorrupt, "{}: …", path)`.
template <typename... Args>
Error MakeError(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return Error{code, fmt::format(format, std::forward<Args>(args)...)};
}

/// Either a value or an Error. `Result<void>` carries no value.
/// Reading the value of a failed result is a bug of ours and aborts with the error's text.
template <typename T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  Result() requires(std::is_void_v<T> || std::is_default_constructible_v<T>) = default;
  Result(Error error) : state_(tl::unexpect, std::move(error)) {}  // NOLINT: implicit by design
  template <typename U = T>
  requires(!std::is_void_v<T> && std::is_convertible_v<U&&, T> &&
           !std::is_same_v<std::remove_cvref_t<U>, Result> &&
           !std::is_same_v<std::remove_cvref_t<U>, Error>) Result(U&& value)
      : state_(std::forward<U>(value)) {}  // NOLINT: implicit by design

  bool ok() const { return state_.has_value(); }
  explicit operator bool() const { return ok(); }

  const Error& error() const {
    CHECK(!ok(), "error() of a result that holds a value");
    return state_.error();
  }

  template <typename U = T>
  requires(!std::is_void_v<U>) U& value() & {
    CheckHoldsValue();
    return *state_;
  }
  template <typename U = T>
  requires(!std::is_void_v<U>) const U& value() const& {
    CheckHoldsValue();
    return *state_;
  }
  template <typename U = T>
  requires(!std::is_void_v<U>) U && value() && {
    CheckHoldsValue();
    return *std::move(state_);
  }

  auto& operator*() & { return value(); }
  const auto& operator*() const& { return value(); }
  auto&& operator*() && { return std::move(*this).value(); }
  auto* operator->() { return &value(); }
  const auto* operator->() const { return &value(); }

 private:
  void CheckHoldsValue() const {
    CHECK(ok(), "value() of a failed result: {}", ToString(state_.error()));
  }

  tl::expected<T, Error> state_;
};

}  // namespace waymark

#define WAYMARK_CONCAT_INNER(a, b) a##b
#define WAYMARK_CONCAT(a, b) WAYMARK_CONCAT_INNER(a, b)

/// Returns the error of a `Result<void>` expression from the enclosing function.
#define WAYMARK_TRY(expression)                                                             \
  do {                                                                                      \
    if (auto waymark_result = (expression); !waymark_result) return waymark_result.error(); \
  } while (false)

/// `WAYMARK_TRY_ASSIGN(const auto camera, ParseCamera(line));` binds the value or returns the
/// error.
#define WAYMARK_TRY_ASSIGN(declaration, expression) \
  WAYMARK_TRY_ASSIGN_INNER(WAYMARK_CONCAT(waymark_result_, __LINE__), declaration, expression)
#define WAYMARK_TRY_ASSIGN_INNER(result, declaration, expression) \
  auto result = (expression);                                     \
  if (!result) return result.error();                             \
  declaration = *std::move(result)
