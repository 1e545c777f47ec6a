//! A fast 64-bit checksum against damage, not against malice.

/// Checksum of a run of bytes.
///
/// FNV-1a's multiply over little-endian words of eight bytes, the last one padded with zeros, each
/// followed by a shift that carries high bits down (bare FNV lets the sign bits of two doubles
/// cancel). Every round maps the running value one to one, so a change confined to one word is
/// always noticed; the length goes in first, so padding cannot hide an end.
pub fn checksum(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let mut sum = mixed(0xcbf2_9ce4_8422_2325, bytes.len() as u64);
    for word in words {
        sum = mixed(sum, u64::from_le_bytes(*word));
    }
    if !rest.is_empty() {
        let mut word = [0; 8];
        word[..rest.len()].copy_from_slice(rest);
        sum = mixed(sum, u64::from_le_bytes(word));
    }
    sum
}

fn mixed(sum: u64, word: u64) -> u64 {
    let product = (sum ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    product ^ (product >> 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sees_zeros_at_the_end_and_paired_sign_flips() {
        assert_ne!(checksum(&[]), checksum(&[0]));
        assert_ne!(checksum(&[1]), checksum(&[1, 0]));
        let mut bytes = [7; 24];
        let before = checksum(&bytes);
        bytes[7] ^= 0x80;
        bytes[15] ^= 0x80;
        assert_ne!(checksum(&bytes), before);
    }
}
