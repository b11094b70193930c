//! SDO server: expedited, normal and segmented transfers, aborts [ETG.1000.6, 5.6.2].
use super::abort;

/// The object dictionary as the server sees it. An error is an abort code.
pub trait Objects {
    fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32>;
    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32>;
}

/// A segmented transfer in progress.
struct Transfer {
    index: u16,
    sub: u8,
    data: Vec<u8>,
    /// Upload: bytes sent so far. Download: bytes announced.
    mark: usize,
    toggle: u8,
}

#[derive(Default)]
pub struct Server {
    upload: Option<Transfer>,
    download: Option<Transfer>,
}

/// Longest download that is taken.
const LONGEST: usize = 4096;

impl Server {
    /// request: 8 bytes or more from the command byte on; room: bytes of the reply, 8 or more.
    pub fn answer(
        &mut self,
        request: &[u8],
        room: usize,
        objects: &mut dyn Objects,
    ) -> Option<Vec<u8>> {
        let command = *request.first()?;
        let index = u16::from_le_bytes([*request.get(1)?, *request.get(2)?]);
        let sub = *request.get(3)?;
        let result = match command >> 5 {
            0 => self.download_segment(command, request, objects),
            1 => self.start_download(command, index, sub, request, objects),
            2 => self.start_upload(command, index, sub, room, objects),
            3 => self.upload_segment(command, room),
            4 => {
                *self = Server::default();
                return None;
            }
            _ => Err(abort::COMMAND),
        };
        Some(result.unwrap_or_else(|code| {
            *self = Server::default();
            let mut reply = vec![0x80, request[1], request[2], sub];
            reply.extend(code.to_le_bytes());
            reply
        }))
    }

    fn start_upload(
        &mut self,
        command: u8,
        index: u16,
        sub: u8,
        room: usize,
        objects: &dyn Objects,
    ) -> Result<Vec<u8>, u32> {
        if command & 0x10 != 0 {
            return Err(abort::UNSUPPORTED_ACCESS);
        }
        let data = objects.upload(index, sub)?;
        let [low, high] = index.to_le_bytes();
        if (1..=4).contains(&data.len()) {
            let size = 4 - data.len() as u8;
            let mut reply = vec![0x43 | size << 2, low, high, sub];
            reply.extend(&data);
            reply.resize(8, 0);
            return Ok(reply);
        }
        let mut reply = vec![0x41, low, high, sub];
        reply.extend((data.len() as u32).to_le_bytes());
        let sent = data.len().min(room - 8);
        reply.extend(&data[..sent]);
        let left = sent < data.len();
        self.upload = left.then_some(Transfer { index, sub, data, mark: sent, toggle: 0 });
        Ok(reply)
    }

    fn upload_segment(&mut self, command: u8, room: usize) -> Result<Vec<u8>, u32> {
        let transfer = self.upload.as_mut().ok_or(abort::COMMAND)?;
        if command & 0x10 != transfer.toggle {
            return Err(abort::TOGGLE);
        }
        let left = &transfer.data[transfer.mark..];
        let sent = left.len().min(room - 1);
        let last = sent == left.len();
        let unused = 7usize.saturating_sub(sent) as u8;
        let mut reply = vec![transfer.toggle | unused << 1 | u8::from(last)];
        reply.extend(&left[..sent]);
        reply.resize(reply.len().max(8), 0);
        transfer.mark += sent;
        transfer.toggle ^= 0x10;
        if last {
            self.upload = None;
        }
        Ok(reply)
    }

    fn start_download(
        &mut self,
        command: u8,
        index: u16,
        sub: u8,
        request: &[u8],
        objects: &mut dyn Objects,
    ) -> Result<Vec<u8>, u32> {
        if command & 0x10 != 0 {
            return Err(abort::UNSUPPORTED_ACCESS);
        }
        let body = request.get(4..).unwrap_or(&[]);
        if command & 2 != 0 {
            let unused = if command & 1 != 0 { command >> 2 & 3 } else { 0 };
            let data = body.get(..4 - usize::from(unused)).ok_or(abort::LENGTH)?;
            objects.download(index, sub, data)?;
        } else {
            let (size, data) = body.split_first_chunk::<4>().ok_or(abort::LENGTH)?;
            let size = u32::from_le_bytes(*size) as usize;
            if size > LONGEST {
                return Err(abort::TOO_LONG);
            }
            if data.len() >= size {
                objects.download(index, sub, &data[..size])?;
            } else {
                let data = data.to_vec();
                self.download = Some(Transfer { index, sub, data, mark: size, toggle: 0 });
            }
        }
        Ok(reply(0x60, index, sub))
    }

    fn download_segment(
        &mut self,
        command: u8,
        request: &[u8],
        objects: &mut dyn Objects,
    ) -> Result<Vec<u8>, u32> {
        let transfer = self.download.as_mut().ok_or(abort::COMMAND)?;
        if command & 0x10 != transfer.toggle {
            return Err(abort::TOGGLE);
        }
        let mut part = &request[1..];
        if part.len() == 7 {
            part = &part[..7 - usize::from(command >> 1 & 7)];
        }
        transfer.data.extend(part);
        if transfer.data.len() > transfer.mark {
            return Err(abort::TOO_LONG);
        }
        let answer = vec![0x20 | transfer.toggle, 0, 0, 0, 0, 0, 0, 0];
        transfer.toggle ^= 0x10;
        if command & 1 != 0 {
            let done = self.download.take().ok_or(abort::COMMAND)?;
            if done.data.len() != done.mark {
                return Err(abort::LENGTH);
            }
            objects.download(done.index, done.sub, &done.data)?;
        }
        Ok(answer)
    }
}

fn reply(command: u8, index: u16, sub: u8) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    vec![command, low, high, sub, 0, 0, 0, 0]
}

#[cfg(test)]
#[path = "sdo_tests.rs"]
pub mod tests;
