need_package libgood-dev
