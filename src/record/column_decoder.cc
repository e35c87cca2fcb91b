#include "record/column_decoder.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "record/log_decoder.h"
#include "record/log_text.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/record/scene_record.h"

namespace twin::record {
namespace {

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

constexpr std::size_t kTopicNode = 0;
constexpr std::size_t kRowNode = 1;

std::int32_t CodeOf(RowBuffer::Part& part, const std::string& text) {
  const auto next = static_cast<std::int32_t>(part.texts.size());
  const auto [known, added] = part.codes.emplace(text, next);
  if (added) part.texts.push_back(text);
  return known->second;
}

std::string ErrorNames(std::uint64_t bits) {
  std::string names;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if ((bits >> i & 1U) == 0) continue;
    if (!names.empty()) names += '|';
    names += Name(static_cast<RobotError>(i));
  }
  return names;
}

/// Sets the last row's value.
template <class T>
void Set(RowBuffer::Part& part, T value) {
  std::memcpy(part.values.data() + part.values.size() - sizeof(T), &value, sizeof(T));
}

}  // namespace

std::size_t RowBuffer::Bytes() const {
  std::size_t bytes = 0;
  for (const Part& part : parts) bytes += part.values.size();
  return bytes;
}

void RowBuffer::Clear() {
  rows = 0;
  for (Part& part : parts) part.values.clear();
}

/// Fields of a message. Source: protobuf encoding,
/// https://protobuf.dev/programming-guides/encoding.
class RowDecoder::Wire {
 public:
  explicit Wire(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool AtEnd() const { return at_ == bytes_.size(); }

  std::uint64_t TakeVarint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && !AtEnd(); shift += 7) {
      const auto byte = static_cast<std::uint64_t>(bytes_[at_++]);
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80) return value;
    }
    throw InputError("the message is cut off in a number");
  }

  std::span<const std::byte> Take(std::uint64_t count) {
    if (count > bytes_.size() - at_) throw InputError("the message is cut off in a field");
    const auto taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }

  std::span<const std::byte> TakeBytes() { return Take(TakeVarint()); }

  double TakeDouble() {
    double value = 0;
    std::memcpy(&value, Take(sizeof(value)).data(), sizeof(value));
    return value;
  }

  void Skip(std::uint32_t type) {
    switch (type) {
      case kVarint: static_cast<void>(TakeVarint()); return;
      case kFixed64: static_cast<void>(Take(8)); return;
      case kBytes: static_cast<void>(TakeBytes()); return;
      case kFixed32: static_cast<void>(Take(4)); return;
      default: throw InputError(fmt::format("a field of wire type {}, which no log has", type));
    }
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

RowDecoder::RowDecoder(const TableInfo& table, std::span<const std::size_t> columns,
                       const Interval& interval)
    : table_(table), source_(SourceOf(table)), interval_(interval), nodes_(2) {
  TWIN_CHECK(!columns.empty() && columns[0] == 0);
  if (source_.row_field != 0) {
    nodes_[kTopicNode][static_cast<std::size_t>(source_.row_field)] = {Use::Kind::kRow, 0};
  }
  for (const std::size_t i : columns) {
    const std::size_t place = empty_.parts.size();
    RowBuffer::Part& part = empty_.parts.emplace_back();
    part.info = &table_.columns[i];
    part.source = &source_.columns[i];
    part.width = part.info->width;
    part.has_width = part.width > 0;
    if (part.source->coding == Coding::kEnum) {
      part.texts = part.source->names;
    } else if (part.info->type == ColumnType::kText) {
      CodeOf(part, {});
    }
    AddUse(source_.row_field != 0 && i > 0 ? kRowNode : kTopicNode, *part.source, place);
  }
  rows_ = empty_;
}

void RowDecoder::AddUse(std::size_t node, const ColumnSource& source, std::size_t part) {
  const auto field = [](int number) { return static_cast<std::size_t>(number); };
  if (source.path.size() > 1) {
    const std::size_t outer = field(source.path.front());
    if (nodes_[node][outer].kind == Use::Kind::kSkip) {
      nodes_[node][outer] = {Use::Kind::kMessage, nodes_.size()};
      nodes_.emplace_back();
    }
    node = nodes_[node][outer].place;
  }
  nodes_[node][field(source.path.back())] = {Use::Kind::kColumn, part};
}

bool RowDecoder::Takes(const McapChannel& channel) const {
  if (channel.topic != table_.topic) return false;
  if (channel.message_encoding == "protobuf" && channel.schema_name == source_.type) return true;
  throw InputError(fmt::format("holds '{}' messages of type '{}'; expected protobuf, {}",
                               channel.message_encoding, channel.schema_name, source_.type));
}

void RowDecoder::Decode(std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes) {
    throw InputError(fmt::format("a message of {} bytes; at most {} are accepted", message.size(),
                                 kMaxMessageBytes));
  }
  BeginRow();
  DecodeMessage(message, kTopicNode);
  if (source_.row_field == 0) {
    EndRow();
    return;
  }
  // The open row holds what all rows of this message share: the time.
  const auto time = rows_.parts[0].At<std::int64_t>(rows_.rows);
  for (std::size_t i = 0; i < row_messages_.size(); ++i) {
    if (i > 0) BeginRow();
    Set(rows_.parts[0], time);
    DecodeMessage(row_messages_[i], kRowNode);
    EndRow();
  }
  if (row_messages_.empty()) {
    for (RowBuffer::Part& part : rows_.parts) {
      part.values.resize(part.values.size() - part.width * BytesOf(part.info->type));
    }
  }
  row_messages_.clear();
}

RowBuffer RowDecoder::Take() {
  return std::exchange(rows_, empty_);
}

void RowDecoder::DecodeMessage(std::span<const std::byte> message, std::size_t node) {
  Wire wire(message);
  while (!wire.AtEnd()) {
    const std::uint64_t tag = wire.TakeVarint();
    const auto type = static_cast<std::uint32_t>(tag & 7U);
    const std::uint64_t number = tag >> 3;
    if (number == 0) throw InputError("a field of number 0");
    const Use use = number < kFields ? nodes_[node][number] : Use();
    if (use.kind == Use::Kind::kColumn) {
      TakeField(wire, type, rows_.parts[use.place]);
    } else if (use.kind == Use::Kind::kSkip || type != kBytes) {
      wire.Skip(type);
    } else if (use.kind == Use::Kind::kRow) {
      row_messages_.push_back(wire.TakeBytes());
    } else {
      DecodeMessage(wire.TakeBytes(), use.place);
    }
  }
}

void RowDecoder::TakeField(Wire& wire, std::uint32_t type, RowBuffer::Part& part) {
  const ColumnSource& source = *part.source;
  const std::string& name = part.info->name;
  const auto is = [&](std::uint32_t expected) {
    if (type == expected) return true;
    wire.Skip(type);
    return false;
  };
  const auto take_error = [&](std::uint64_t number) {
    if (number >= kRobotErrorCount) {
      throw InputError(fmt::format("{} has the unknown value {}", name, number));
    }
    part.bits |= std::uint64_t{1} << number;
  };
  switch (source.coding) {
    case Coding::kDoubles:
      if (type == kFixed64) {
        TakeDoubles(wire.Take(sizeof(double)), part);
      } else if (is(kBytes)) {
        TakeDoubles(wire.TakeBytes(), part);
      }
      return;
    case Coding::kDouble:
      if (is(kFixed64)) Set(part, wire.TakeDouble());
      return;
    case Coding::kTime:
      if (is(kVarint)) {
        Set(part,
            DecodeTime(static_cast<std::int64_t>(wire.TakeVarint())).time_since_epoch().count());
      }
      return;
    case Coding::kUint64:
      if (is(kVarint)) Set(part, wire.TakeVarint());
      return;
    case Coding::kUint32:
      if (is(kVarint)) {
        const auto value = static_cast<std::uint32_t>(wire.TakeVarint());
        if (value > source.most) {
          throw InputError(
              fmt::format("{} is {}; at most {} is accepted", name, value, source.most));
        }
        Set(part, value);
      }
      return;
    case Coding::kBool:
      if (is(kVarint)) Set(part, static_cast<std::uint8_t>(wire.TakeVarint() != 0));
      return;
    case Coding::kEnum:
      if (is(kVarint)) {
        const auto value = static_cast<std::int32_t>(wire.TakeVarint());
        if (value < 0 || static_cast<std::size_t>(value) >= source.names.size()) {
          throw InputError(fmt::format("{} has the unknown value {}", name, value));
        }
        Set(part, value);
      }
      return;
    case Coding::kErrors:
      if (type == kVarint) {
        take_error(wire.TakeVarint());
      } else if (is(kBytes)) {
        Wire numbers(wire.TakeBytes());
        while (!numbers.AtEnd()) take_error(numbers.TakeVarint());
      }
      return;
    case Coding::kViolation:
      if (is(kBytes)) {
        const auto bytes = wire.TakeBytes();
        pb::Violation message;
        if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
          throw InputError("not a message of type panda_twin.Violation");
        }
        if (!part.violation) part.violation.emplace();
        part.violation->MergeFrom(message);
      }
      return;
    case Coding::kString:
      if (is(kBytes)) {
        const auto text = wire.TakeBytes();
        Set(part,
            CodeOf(part, ToPrintable({reinterpret_cast<const char*>(text.data()), text.size()})));
      }
      return;
  }
}

void RowDecoder::TakeDoubles(std::span<const std::byte> values, RowBuffer::Part& part) {
  const std::size_t count = values.size() / sizeof(double);
  const std::size_t most = part.has_width ? part.width : SceneRecord::kMostPositions;
  if (values.size() % sizeof(double) != 0 || count > most - part.count) {
    throw InputError(fmt::format("{} has {} values; it must have {} or none", part.info->name,
                                 part.count + count, most));
  }
  if (!part.has_width) {  // the first row of a log that decides
    part.values.insert(part.values.end(), values.begin(), values.end());
  } else {
    std::byte* const row = part.values.data() + rows_.rows * part.width * sizeof(double);
    std::memcpy(row + part.count * sizeof(double), values.data(), values.size());
  }
  part.count += count;
}

void RowDecoder::BeginRow() {
  for (RowBuffer::Part& part : rows_.parts) {
    part.count = 0;
    part.bits = 0;
    part.violation.reset();
    if (!part.has_width) continue;
    const std::size_t begin = part.values.size();
    part.values.resize(begin + part.width * BytesOf(part.info->type));
    if (!part.info->may_be_absent) continue;
    constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < part.width; ++i) {
      std::memcpy(part.values.data() + begin + i * sizeof(double), &kAbsent, sizeof(double));
    }
  }
}

void RowDecoder::EndRow() {
  for (RowBuffer::Part& part : rows_.parts) {
    switch (part.source->coding) {
      case Coding::kDoubles:
        if (!part.has_width) {
          if (rows_.rows > 0 && part.count > 0) {
            throw InputError(
                fmt::format("{} has {} values; it had none", part.info->name, part.count));
          }
          part.width = part.count;
          part.has_width = part.count > 0;
        } else if (part.count != 0 && part.count != part.width) {
          throw InputError(fmt::format("{} has {} values; it must have {} or none", part.info->name,
                                       part.count, part.width));
        }
        break;
      case Coding::kErrors:
        if (part.bits != 0) Set(part, CodeOf(part, ErrorNames(part.bits)));
        break;
      case Coding::kViolation:
        if (part.violation) Set(part, CodeOf(part, Describe(DecodeViolation(*part.violation))));
        break;
      default: break;
    }
  }
  ++rows_.rows;
  if (interval_.Has(rows_.parts[0].At<std::int64_t>(rows_.rows - 1))) return;
  --rows_.rows;
  for (RowBuffer::Part& part : rows_.parts) {
    part.values.resize(rows_.rows * part.width * BytesOf(part.info->type));
  }
}

Table Join(const TableInfo& table, std::span<RowBuffer> buffers) {
  TWIN_CHECK(!buffers.empty());
  Table joined{.info = &table};
  for (const RowBuffer& buffer : buffers) joined.rows += buffer.rows;
  for (std::size_t i = 0; i < buffers.front().parts.size(); ++i) {
    RowBuffer::Part whole;  // of which only the Column is kept
    whole.info = buffers.front().parts[i].info;
    whole.width = whole.info->width;
    whole.texts = buffers.front().parts[i].source->names;
    whole.values.reserve([&] {
      std::size_t bytes = 0;
      for (const RowBuffer& buffer : buffers) bytes += buffer.parts[i].values.size();
      return bytes;
    }());
    for (RowBuffer& buffer : buffers) {
      RowBuffer::Part part = std::move(buffer.parts[i]);
      if (buffer.rows == 0) continue;
      if (whole.values.empty()) {
        whole.width = part.width;
      } else if (whole.width != part.width) {
        throw InputError(fmt::format("{} has {} values in one row and {} in another",
                                     part.info->name, whole.width, part.width));
      }
      if (part.info->type == ColumnType::kText && part.source->coding != Coding::kEnum) {
        std::vector<std::int32_t> codes;
        for (const std::string& text : part.texts) codes.push_back(CodeOf(whole, text));
        for (std::size_t row = 0; row < buffer.rows; ++row) {
          const auto code = static_cast<std::size_t>(part.At<std::int32_t>(row));
          std::memcpy(part.values.data() + row * sizeof(std::int32_t), &codes[code],
                      sizeof(std::int32_t));
        }
      }
      whole.values.insert(whole.values.end(), part.values.begin(), part.values.end());
    }
    joined.columns.push_back(
        std::make_shared<const Column>(std::move(static_cast<Column&>(whole))));
  }
  return joined;
}

}  // namespace twin::record
