def check_names(module, findings): pass
