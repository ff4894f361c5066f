//! GPUs: what wgpu can draw with.

use std::path::PathBuf;

use serde_json::json;

use super::access;
use super::finding::{Finding, Item};
use super::remedy::{install, join_group};

pub(super) fn examine() -> Result<Finding, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let infos: Vec<_> = adapters.iter().map(wgpu::Adapter::get_info).collect();
    Ok(judge(&infos, &render_nodes()))
}

/// The GPUs that the kernel of Linux knows, each with whether this user may use it.
fn render_nodes() -> Vec<(PathBuf, bool)> {
    let Ok(entries) = std::fs::read_dir("/dev/dri") else {
        return Vec::new();
    };
    entries
        .flatten()
        .filter(|entry| entry.file_name().as_encoded_bytes().starts_with(b"renderD"))
        .map(|entry| (entry.path(), access::is_granted(&entry.path())))
        .collect()
}

fn judge(infos: &[wgpu::AdapterInfo], render_nodes: &[(PathBuf, bool)]) -> Finding {
    let mut finding = Finding::default();
    for info in infos {
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "a card",
            wgpu::DeviceType::IntegratedGpu => "in the processor",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "of unknown kind",
        };
        let driver = [info.driver.as_str(), info.driver_info.as_str()]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        finding.found(Item::new(
            &info.name,
            format!("{kind}, by {}, driver {driver}", info.backend),
            json!({
                "software": info.device_type == wgpu::DeviceType::Cpu,
                "kind": format!("{:?}", info.device_type),
                "backend": info.backend.to_str(),
                "driver": driver,
            }),
        ));
    }
    if infos.is_empty() {
        finding.advise(format!(
            "There is nothing to draw a window with, not even software; flights can still be \
             written to files. For both a GPU of AMD or Intel and software: {}. For NVIDIA, its own \
             driver.",
            install(&["libvulkan1", "mesa-vulkan-drivers"])
        ));
    }
    if infos
        .iter()
        .any(|info| info.device_type != wgpu::DeviceType::Cpu)
    {
        return finding;
    }
    if !infos.is_empty() {
        finding.advise("Windows are drawn in software, which takes time from casting.".to_owned());
    }
    let refused = render_nodes.iter().find(|(_, granted)| !granted);
    if let Some((node, _)) = refused {
        let group = access::group_of(node);
        finding.advise(format!(
            "There is a GPU at {} that this user may not use: {}.",
            node.display(),
            join_group(group.as_deref().unwrap_or("render"))
        ));
    } else if !render_nodes.is_empty() {
        finding.advise(format!(
            "There is a GPU, but no driver that draws with it: {} for AMD and Intel, NVIDIA's own \
             for NVIDIA.",
            install(&["mesa-vulkan-drivers"])
        ));
    } else if cfg!(target_os = "linux") {
        finding.advise(
            "The kernel knows no GPU (/dev/dri has none): in a container, share /dev/dri with it; \
             for NVIDIA, install its own driver."
                .to_owned(),
        );
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(kind: wgpu::DeviceType) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo::new(kind, wgpu::Backend::Vulkan)
    }

    #[test]
    fn software_alone_lacks_a_gpu_or_its_driver_or_permission() {
        let advice = |infos: &[wgpu::AdapterInfo], nodes: &[(PathBuf, bool)]| {
            judge(infos, nodes).advice.join(" ")
        };
        let node = |granted| [(PathBuf::from("/dev/dri/renderD128"), granted)];
        let software = [info(wgpu::DeviceType::Cpu)];
        assert!(advice(&[], &[]).contains("libvulkan1"));
        assert!(advice(&software, &node(true)).contains("no driver"));
        assert!(advice(&software, &node(false)).contains("usermod -aG render"));
        let both = [
            info(wgpu::DeviceType::Cpu),
            info(wgpu::DeviceType::DiscreteGpu),
        ];
        assert_eq!(advice(&both, &node(false)), "");
        let json = judge(&both, &[]).json();
        assert_eq!(json[0]["software"], true);
        assert_eq!(json[1]["software"], false);
    }
}
