//! Process-data objects: maps 0x1600.., 0x1A00.. and their assignment 0x1C12, 0x1C13.
use super::abort;

/// One mapped object: index, sub-index, bits; as in the map objects, index in the high half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    pub index: u16,
    pub sub: u8,
    pub bits: u8,
}

impl Entry {
    pub const fn new(index: u16, bits: u8) -> Entry {
        Entry { index, sub: 0, bits }
    }

    pub fn word(&self) -> u32 {
        u32::from(self.index) << 16 | u32::from(self.sub) << 8 | u32::from(self.bits)
    }

    pub fn parse(word: u32) -> Entry {
        Entry { index: (word >> 16) as u16, sub: (word >> 8) as u8, bits: word as u8 }
    }

    /// A gap that carries nothing.
    pub fn is_pad(&self) -> bool {
        self.index < 0x20
    }

    pub fn bytes(&self) -> usize {
        usize::from(self.bits) / 8
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Pdo {
    pub index: u16,
    pub entries: Vec<Entry>,
    pub fixed: bool,
}

/// What a drive allows.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    pub pdo_bytes: usize,
    pub total_bytes: usize,
}

/// All maps of one direction and which of them are used.
#[derive(Debug, Clone)]
pub struct Direction {
    pub pdos: Vec<Pdo>,
    pub assigned: Vec<u16>,
    pub limits: Limits,
    /// Entries and assignments beyond the counts that were last set.
    spare: Vec<(u16, u8, u32)>,
}

impl Direction {
    pub fn new(pdos: Vec<Pdo>, assigned: Vec<u16>, limits: Limits) -> Direction {
        Direction { pdos, assigned, limits, spare: Vec::new() }
    }

    /// Mapped entries in the order of the process data.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        let find = |index: &u16| self.pdos.iter().find(|pdo| pdo.index == *index);
        self.assigned.iter().filter_map(find).flat_map(|pdo| &pdo.entries)
    }

    pub fn bytes(&self) -> usize {
        self.entries().map(Entry::bytes).sum()
    }

    /// Reads a map (its index) or the assignment (any other index).
    pub fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let Some(pdo) = self.pdos.iter().find(|pdo| pdo.index == index) else {
            return match sub {
                0 => Ok(vec![self.assigned.len() as u8]),
                _ => nth(&self.assigned, sub).map(|index| index.to_le_bytes().to_vec()),
            };
        };
        match sub {
            0 => Ok(vec![pdo.entries.len() as u8]),
            _ => nth(&pdo.entries, sub).map(|entry| entry.word().to_le_bytes().to_vec()),
        }
    }

    /// mappable: whether the drive has this object for this direction and of that size.
    pub fn download(
        &mut self,
        index: u16,
        sub: u8,
        data: &[u8],
        mappable: &dyn Fn(&Entry) -> bool,
    ) -> Result<(), u32> {
        let is_map = self.pdos.iter().any(|pdo| pdo.index == index);
        let width = if sub == 0 {
            1
        } else if is_map {
            4
        } else {
            2
        };
        if data.len() != width {
            return Err(abort::LENGTH);
        }
        let mut word = [0; 4];
        word[..width].copy_from_slice(data);
        let word = u32::from_le_bytes(word);
        let most = if is_map { 8 } else { 4 };
        if sub > most || sub == 0 && word > u32::from(most) {
            return Err(if sub == 0 { abort::VALUE_RANGE } else { abort::NO_SUBINDEX });
        }
        if self.pdos.iter().any(|pdo| pdo.index == index && pdo.fixed) {
            return Err(abort::READ_ONLY);
        }
        if sub > 0 {
            return self.note(index, sub, word, is_map, mappable);
        }
        self.set_count(index, word as u8, is_map)
    }

    /// Entries may be written while the count is 0.
    fn note(
        &mut self,
        index: u16,
        sub: u8,
        word: u32,
        is_map: bool,
        mappable: &dyn Fn(&Entry) -> bool,
    ) -> Result<(), u32> {
        if self.upload(index, 0)? != [0] {
            return Err(abort::UNSUPPORTED_ACCESS);
        }
        let known = if is_map {
            let entry = Entry::parse(word);
            let whole = entry.bits > 0 && entry.bits.is_multiple_of(8);
            whole && (entry.is_pad() || mappable(&entry))
        } else {
            self.pdos.iter().any(|pdo| u32::from(pdo.index) == word)
        };
        if !known {
            return Err(abort::NOT_MAPPABLE);
        }
        self.spare.retain(|(i, s, _)| (*i, *s) != (index, sub));
        self.spare.push((index, sub, word));
        Ok(())
    }

    fn set_count(&mut self, index: u16, count: u8, is_map: bool) -> Result<(), u32> {
        let word = |sub| {
            let of = |(i, s, word): &(u16, u8, u32)| ((*i, *s) == (index, sub)).then_some(*word);
            self.spare.iter().find_map(of).ok_or(abort::VALUE_RANGE)
        };
        let words = (1..=count).map(word).collect::<Result<Vec<u32>, u32>>()?;
        let mut next = self.clone();
        if let Some(pdo) = next.pdos.iter_mut().find(|pdo| pdo.index == index) {
            pdo.entries = words.iter().map(|word| Entry::parse(*word)).collect();
            if pdo.entries.iter().map(Entry::bytes).sum::<usize>() > self.limits.pdo_bytes {
                return Err(abort::PDO_TOO_LONG);
            }
        } else if !is_map {
            next.assigned = words.iter().map(|word| *word as u16).collect();
        }
        if next.bytes() > self.limits.total_bytes {
            return Err(abort::PDO_TOO_LONG);
        }
        *self = next;
        Ok(())
    }
}

fn nth<T: Copy>(items: &[T], sub: u8) -> Result<T, u32> {
    items.get(usize::from(sub) - 1).copied().ok_or(abort::NO_SUBINDEX)
}

#[cfg(test)]
#[path = "pdo_tests.rs"]
mod tests;
