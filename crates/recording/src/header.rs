//! The header of a stream: its schema message, checked before the decoder sees it.

use arrow_ipc::convert::fb_to_schema;
use arrow_ipc::{Field, Type, root_as_message};
use arrow_schema::Schema;

use super::RecordingFault;

/// The continuation and the length that come before the message.
const PREFIX_BYTES: usize = 8;

/// The schema of a stream, from its first message.
pub(super) fn read(bytes: &[u8]) -> Result<Schema, RecordingFault> {
    let cut = || RecordingFault::NothingWhole;
    let length = bytes.get(4..PREFIX_BYTES).and_then(|length| length.try_into().ok()).ok_or_else(cut)?;
    let length = usize::try_from(i32::from_le_bytes(length)).map_err(RecordingFault::damaged)?;
    let message = bytes.get(PREFIX_BYTES..PREFIX_BYTES + length).ok_or_else(cut)?;
    let message = root_as_message(message).map_err(RecordingFault::damaged)?;
    let schema = message.header_as_schema().ok_or_else(|| RecordingFault::damaged("its first message is no schema"))?;
    let fields = schema.fields().ok_or_else(|| RecordingFault::damaged("its schema has no columns"))?;
    if fields.iter().all(is_one_of_ours) {
        Ok(fb_to_schema(schema))
    } else {
        Err(RecordingFault::damaged("a column has a type that no recording has"))
    }
}

/// Whether a column has a type of a recording's. Arrow's own conversion panics on types that do not exist, as in a
/// damaged header.
fn is_one_of_ours(field: Field<'_>) -> bool {
    let known = match field.type_type() {
        Type::Int => field.type_as_int().is_some_and(|int| [16, 32, 64].contains(&int.bitWidth()) && !int.is_signed()),
        Type::FloatingPoint => {
            field.type_as_floating_point().is_some_and(|float| float.precision() == arrow_ipc::Precision::DOUBLE)
        }
        Type::Utf8 => true,
        _ => false,
    };
    known && field.dictionary().is_none() && field.name().is_some()
}
