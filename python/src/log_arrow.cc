#include "log_arrow.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

// The ABI, as its specification spells it.
extern "C" {
struct ArrowSchema {
  const char* format;
  const char* name;
  const char* metadata;
  int64_t flags;
  int64_t n_children;
  ArrowSchema** children;
  ArrowSchema* dictionary;
  void (*release)(ArrowSchema*);
  void* private_data;
};

struct ArrowArray {
  int64_t length;
  int64_t null_count;
  int64_t offset;
  int64_t n_buffers;
  int64_t n_children;
  const void** buffers;
  ArrowArray** children;
  ArrowArray* dictionary;
  void (*release)(ArrowArray*);
  void* private_data;
};

struct ArrowArrayStream {
  int (*get_schema)(ArrowArrayStream*, ArrowSchema*);
  int (*get_next)(ArrowArrayStream*, ArrowArray*);
  const char* (*get_last_error)(ArrowArrayStream*);
  void (*release)(ArrowArrayStream*);
  void* private_data;
};
}

namespace twin::python {
namespace {

using record::Column;
using record::ColumnType;
using record::Table;

constexpr int64_t kNullable = 2;

/// What a struct of the interface owns: it dies with the struct's release().
template <class Struct>
struct Owned {
  std::vector<std::unique_ptr<Struct>> storage{};  ///< of children and dictionary
  std::vector<Struct*> children{};
  std::vector<const void*> buffers{};
  std::vector<std::vector<std::byte>> bytes{};  ///< of buffers that are not a column's
  std::shared_ptr<const Column> column{};
  std::string format{};
  std::string name{};
};

template <class Struct>
void Release(Struct* of) {
  const std::unique_ptr<Owned<Struct>> owned(static_cast<Owned<Struct>*>(of->private_data));
  for (const auto& part : owned->storage) {
    if (part->release != nullptr) part->release(part.get());  // else a consumer has taken it
  }
  of->release = nullptr;
}

/// Hands `owned` to a struct.
template <class Struct>
void Give(std::unique_ptr<Owned<Struct>> owned, Struct& to, Struct* dictionary) {
  to.n_children = static_cast<int64_t>(owned->children.size());
  to.children = owned->children.empty() ? nullptr : owned->children.data();
  to.dictionary = dictionary;
  to.release = &Release<Struct>;
  to.private_data = owned.release();
}

template <class Struct>
Struct& AddPart(Owned<Struct>& owned) {
  return *owned.storage.emplace_back(std::make_unique<Struct>());
}

template <class Struct>
Struct& AddChild(Owned<Struct>& owned) {
  Struct& child = AddPart(owned);
  owned.children.push_back(&child);
  return child;
}

const char* FormatOf(ColumnType type) {
  switch (type) {
    case ColumnType::kFloat64: return "g";
    case ColumnType::kInt64: return "l";
    case ColumnType::kUint64: return "L";
    case ColumnType::kUint32: return "I";
    case ColumnType::kBool: return "b";
    case ColumnType::kText: return "i";  // the numbers of a dictionary
  }
  return "n";
}

/// @returns what the caller may add children to, until it gives it to `schema`.
std::unique_ptr<Owned<ArrowSchema>> BeginSchema(std::string format, std::string name,
                                                ArrowSchema& schema) {
  auto owned = std::make_unique<Owned<ArrowSchema>>();
  owned->format = std::move(format);
  owned->name = std::move(name);
  schema = {};
  schema.format = owned->format.c_str();
  schema.name = owned->name.c_str();
  schema.flags = kNullable;
  return owned;
}

void DescribeColumn(const Column& column, ArrowSchema& schema) {
  const char* const format = FormatOf(column.info->type);
  const bool is_vector = column.info->is_vector;
  auto owned = BeginSchema(is_vector ? fmt::format("+w:{}", column.width) : format,
                           column.info->name, schema);
  ArrowSchema* dictionary = nullptr;
  if (is_vector) {
    ArrowSchema& item = AddChild(*owned);
    Give(BeginSchema(format, "item", item), item, static_cast<ArrowSchema*>(nullptr));
  } else if (column.info->type == ColumnType::kText) {
    dictionary = &AddPart(*owned);
    Give(BeginSchema("u", "", *dictionary), *dictionary, static_cast<ArrowSchema*>(nullptr));
  }
  Give(std::move(owned), schema, dictionary);
}

void DescribeTable(const Table& table, ArrowSchema& schema) {
  auto owned = BeginSchema("+s", "", schema);
  for (const auto& column : table.columns) DescribeColumn(*column, AddChild(*owned));
  Give(std::move(owned), schema, static_cast<ArrowSchema*>(nullptr));
}

void GiveArray(std::unique_ptr<Owned<ArrowArray>> owned, std::size_t length, ArrowArray& array,
               ArrowArray* dictionary = nullptr) {
  array = {};
  array.length = static_cast<int64_t>(length);
  array.n_buffers = static_cast<int64_t>(owned->buffers.size());
  array.buffers = owned->buffers.data();
  Give(std::move(owned), array, dictionary);
}

void FillTexts(const std::vector<std::string>& texts, ArrowArray& array) {
  auto owned = std::make_unique<Owned<ArrowArray>>();
  std::string all;
  std::vector<std::int32_t> offsets{0};
  for (const std::string& text : texts) {
    all += text;
    offsets.push_back(static_cast<std::int32_t>(all.size()));
  }
  const auto copy = [&](const auto& from) {
    const auto bytes = std::as_bytes(std::span(from));
    return owned->bytes.emplace_back(bytes.begin(), bytes.end()).data();
  };
  owned->bytes.reserve(2);
  const void* const offset_bytes = copy(offsets);
  const void* const text_bytes = copy(all);
  owned->buffers = {nullptr, offset_bytes, text_bytes};
  GiveArray(std::move(owned), texts.size(), array);
}

std::vector<std::byte> BitsOf(const std::byte* values, std::size_t rows) {
  std::vector<std::byte> bits((rows + 7) / 8);
  for (std::size_t i = 0; i < rows; ++i) bits[i / 8] |= values[i] << (i % 8);
  return bits;
}

void FillColumn(const std::shared_ptr<const Column>& column, std::size_t begin, std::size_t rows,
                ArrowArray& array) {
  auto owned = std::make_unique<Owned<ArrowArray>>();
  const ColumnType type = column->info->type;
  const std::byte* const values =
      column->values.data() + begin * column->width * record::BytesOf(type);
  owned->column = column;
  if (column->info->is_vector) {
    auto items = std::make_unique<Owned<ArrowArray>>();
    items->column = column;
    items->buffers = {nullptr, values};
    GiveArray(std::move(items), rows * column->width, AddChild(*owned));
    owned->buffers = {nullptr};
    GiveArray(std::move(owned), rows, array);
    return;
  }
  ArrowArray* dictionary = nullptr;
  owned->buffers = {nullptr, values};
  if (type == ColumnType::kBool) {
    owned->buffers[1] = owned->bytes.emplace_back(BitsOf(values, rows)).data();
  } else if (type == ColumnType::kText) {
    dictionary = &AddPart(*owned);
    FillTexts(column->texts, *dictionary);
  }
  GiveArray(std::move(owned), rows, array, dictionary);
}

void FillTable(const Table& table, ArrowArray& array) {
  auto owned = std::make_unique<Owned<ArrowArray>>();
  for (const auto& column : table.columns) {
    FillColumn(column, table.begin, table.rows, AddChild(*owned));
  }
  owned->buffers = {nullptr};
  GiveArray(std::move(owned), table.rows, array);
}

struct Stream {
  Table table;
  bool is_read = false;
};

void ReleaseStream(ArrowArrayStream* stream) {
  delete static_cast<Stream*>(stream->private_data);
  stream->release = nullptr;
}

int GetSchema(ArrowArrayStream* stream, ArrowSchema* schema) {
  DescribeTable(static_cast<Stream*>(stream->private_data)->table, *schema);
  return 0;
}

int GetNext(ArrowArrayStream* stream, ArrowArray* array) {
  auto& state = *static_cast<Stream*>(stream->private_data);
  if (std::exchange(state.is_read, true)) {
    array->release = nullptr;  // the end
  } else {
    FillTable(state.table, *array);
  }
  return 0;
}

const char* GetLastError(ArrowArrayStream* /*stream*/) {
  return nullptr;
}

}  // namespace

nanobind::capsule ArrowStreamOf(const record::Table& table) {
  auto stream = std::make_unique<ArrowArrayStream>();
  stream->get_schema = &GetSchema;
  stream->get_next = &GetNext;
  stream->get_last_error = &GetLastError;
  stream->release = &ReleaseStream;
  stream->private_data = new Stream{table};
  return {stream.release(), "arrow_array_stream", [](void* pointer) noexcept {
            const std::unique_ptr<ArrowArrayStream> own(static_cast<ArrowArrayStream*>(pointer));
            if (own->release != nullptr) own->release(own.get());
          }};
}

}  // namespace twin::python
