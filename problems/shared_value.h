// A value that many owners read, and that none of them changes under the others' eyes.
#pragma once

#include <memory>
#include <utility>

namespace sagitta {

// Copies share one value, so that copying costs nothing whatever its size. An owner who changes it (`Own`) first gets a
// value of his own, unless nobody else holds it.
template <typename T>
class SharedValue {
 public:
  SharedValue() : value_(std::make_shared<T>()) {}
  SharedValue(T value) : value_(std::make_shared<T>(std::move(value))) {}  // NOLINT(google-explicit-constructor)

  const T& operator*() const { return *value_; }
  const T* operator->() const { return value_.get(); }

  T* Own();

 private:
  std::shared_ptr<T> value_;
};

template <typename T>
T* SharedValue<T>::Own() {
  if (value_.use_count() > 1) value_ = std::make_shared<T>(*value_);
  return value_.get();
}

}  // namespace sagitta
